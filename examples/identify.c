/* Identifies a recording with libdecid's built-in model and prints what was found.

     cc identify.c -o identify $(pkg-config --cflags --libs decid)
     ./identify recording.csv [MASS_KG HEIGHT_M] */
#include <decid/decid.h>
#include <stdio.h>
#include <stdlib.h>

int main(int count, char** arguments) {
  decid_identify_options options;
  decid_model* model = NULL;
  decid_recording* recording = NULL;
  decid_result* result = NULL;
  size_t i;
  if (count != 2 && count != 4) {
    fprintf(stderr, "usage: %s RECORDING [MASS_KG HEIGHT_M]\n", arguments[0]);
    return 2;
  }
  decid_identify_defaults(&options, sizeof options);
  if (count == 4) {
    options.mass_kg = atof(arguments[2]);
    options.height_m = atof(arguments[3]);
  }
  if (decid_model_load(NULL, &model) || decid_recording_read(arguments[1], NULL, &recording) ||
      decid_identify(model, recording, &options, &result)) {
    fprintf(stderr, "%s\n", decid_error_text());
    decid_recording_free(recording);
    decid_model_free(model);
    return 2;
  }
  if (decid_result_trust(result) == DECID_NOT_USABLE)
    printf("not usable: do not use these values; the warnings below say why\n");
  else if (decid_result_trust(result) == DECID_WITH_CAUTION)
    printf("caution: see the warnings below\n");
  for (i = 0; i < decid_result_parameters(result); ++i) {
    const decid_parameter* found = decid_result_parameter(result, i);
    printf("%-8s %12.5g   90%%: %.5g to %.5g %s\n", found->name, found->value, found->interval90[0],
           found->interval90[1], found->unit);
  }
  for (i = 0; i < decid_result_warnings(result); ++i)
    printf("%s: %s\n", decid_result_warning(result, i)->code, decid_result_warning(result, i)->text);
  decid_result_free(result);
  decid_recording_free(recording);
  decid_model_free(model);
  return 0;
}
