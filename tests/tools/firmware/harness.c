/* Runs an exported model, called model, on the host: identifies the trials of a file in every way there is, demands the
   same bits of all, and tries every error. Compiled as C99 and as C++. Usage: harness sway.bin images.bin results.bin
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "model.h"

static model_arena arena;
static float sway[MODEL_SAMPLES];
static float image[MODEL_IMAGE_CHANNELS * MODEL_IMAGE_ROWS * MODEL_IMAGE_COLUMNS];

#ifdef DEVIATIONS
#define VALUES (2 * MODEL_PARAMETERS)
#else
#define VALUES MODEL_PARAMETERS
#endif
#ifdef FAMILIARITY
#define RESULTS (VALUES + 2) /* a double behind them */
#else
#define RESULTS VALUES
#endif

static int failures = 0;
#define REQUIRE(condition) require((condition), #condition, __LINE__)

static void require(int holds, const char* what, int line) {
  if (!holds) {
    ++failures;
    printf("line %d: %s does not hold\n", line, what);
  }
}

/* Appends the standard deviations, if the model knows them, and the distance, if it can be asked for. */
static void add_rest(float* results) {
#ifdef DEVIATIONS
  REQUIRE(model_stddevs(&results[MODEL_PARAMETERS], &arena) == MODEL_OK);
#endif
#ifdef FAMILIARITY
  double distance = 0.0;
  REQUIRE(model_distance(&distance, &arena) == MODEL_OK);
  memcpy(&results[VALUES], &distance, sizeof distance);
#endif
  (void)results;
}

#ifdef INCREMENTAL
/* Feeds `samples` at a time and works `units` each time. */
static int as_they_arrive(float* parameters, int samples, int units) {
  int fed = 0, result = model_begin(&arena);
  while (fed < MODEL_SAMPLES && result >= 0) {
    const int count = (MODEL_SAMPLES - fed < samples) ? MODEL_SAMPLES - fed : samples;
    int unit;
    result = model_feed(&sway[fed], count, &arena);
    fed += count;
    for (unit = 0; unit < units && result >= 0; ++unit) result = model_work(&arena);
  }
  while (result == MODEL_OK && (result = model_work(&arena)) == MODEL_MORE) {
  }
  while (result == MODEL_MORE) result = model_work(&arena);
  if (result == MODEL_OK) result = model_result(parameters, &arena);
  if (result == MODEL_OK) add_rest(parameters);
  return result;
}

static void check_incremental_errors(void) {
  float parameters[7];
  const float bad = (float)INFINITY;
  memset(&arena, 0, sizeof arena);
  REQUIRE(model_feed(sway, 1, &arena) == MODEL_ERROR_STATE);
  REQUIRE(model_work(&arena) == MODEL_ERROR_STATE);
  REQUIRE(model_result(parameters, &arena) == MODEL_ERROR_STATE);
  REQUIRE(model_identify(sway, parameters, &arena) == MODEL_OK);
  REQUIRE(model_feed(sway, 1, &arena) == MODEL_ERROR_STATE); /* that was no beginning */
  REQUIRE(model_begin(NULL) == MODEL_ERROR_NULL);
  REQUIRE(model_begin((unsigned char*)&arena + 1) == MODEL_ERROR_ALIGNMENT);
  REQUIRE(model_begin(&arena) == MODEL_OK);
  REQUIRE(model_feed(NULL, 1, &arena) == MODEL_ERROR_NULL);
  REQUIRE(model_feed(sway, -1, &arena) == MODEL_ERROR_COUNT);
  REQUIRE(model_feed(sway, MODEL_SAMPLES, &arena) == MODEL_OK);
  REQUIRE(model_feed(sway, 1, &arena) == MODEL_ERROR_COUNT);
  REQUIRE(model_result(parameters, &arena) == MODEL_ERROR_STATE);
  REQUIRE(model_result(NULL, &arena) == MODEL_ERROR_NULL);
  REQUIRE(model_begin(&arena) == MODEL_OK);
  REQUIRE(model_feed(&bad, 1, &arena) == MODEL_ERROR_NOT_FINITE);
  /* A sample that was refused can be fed again. */
  REQUIRE(model_feed(sway, MODEL_SAMPLES, &arena) == MODEL_OK);
  REQUIRE(model_work(&arena) == MODEL_MORE);
}
#endif

/* Large pixels, though finite, may make outputs that are not: then nothing is written. */
static void check_large_pixels(void) {
  static float large[MODEL_IMAGE_CHANNELS * MODEL_IMAGE_ROWS * MODEL_IMAGE_COLUMNS];
  float parameters[7] = {1, 2, 3, 4, 5, 6, 7};
  size_t i;
  int result;
  for (i = 0; i < sizeof large / sizeof large[0]; ++i) large[i] = (i % 2 == 0) ? 3e38F : -3e38F;
  result = model_identify_image(large, parameters, &arena);
  REQUIRE(result == MODEL_OK || result == MODEL_ERROR_NOT_FINITE);
  for (i = 0; i < 7; ++i)
    REQUIRE((result == MODEL_OK) ? (isfinite(parameters[i]) != 0) : (parameters[i] == (float)(i + 1)));
}

/* The self-test leaves no result that could be taken for a trial's. */
static void check_after_self_test(void) {
#ifdef DEVIATIONS
  float stddevs[7];
#endif
#ifdef FAMILIARITY
  double distance = 7.0;
#endif
  REQUIRE(model_self_test(&arena) == MODEL_OK);
#ifdef DEVIATIONS
  REQUIRE(model_stddevs(stddevs, &arena) == MODEL_ERROR_STATE);
#endif
#ifdef FAMILIARITY
  REQUIRE(model_distance(&distance, &arena) == MODEL_ERROR_STATE);
#endif
}

static void check_errors(void) {
  float parameters[7] = {1, 2, 3, 4, 5, 6, 7};
  const float kept = sway[MODEL_SAMPLES / 2], pixel = image[3];
  REQUIRE(model_identify(NULL, parameters, &arena) == MODEL_ERROR_NULL);
  REQUIRE(model_identify(sway, NULL, &arena) == MODEL_ERROR_NULL);
  REQUIRE(model_identify(sway, parameters, NULL) == MODEL_ERROR_NULL);
  REQUIRE(model_identify(sway, parameters, (unsigned char*)&arena + 4) == MODEL_ERROR_ALIGNMENT);
  sway[MODEL_SAMPLES / 2] = (float)NAN;
  REQUIRE(model_identify(sway, parameters, &arena) == MODEL_ERROR_NOT_FINITE);
  sway[MODEL_SAMPLES / 2] = -(float)INFINITY;
  REQUIRE(model_identify(sway, parameters, &arena) == MODEL_ERROR_NOT_FINITE);
  sway[MODEL_SAMPLES / 2] = kept;
  REQUIRE(model_identify_image(NULL, parameters, &arena) == MODEL_ERROR_NULL);
  REQUIRE(model_identify_image(image, NULL, &arena) == MODEL_ERROR_NULL);
  REQUIRE(model_identify_image(image, parameters, NULL) == MODEL_ERROR_NULL);
  REQUIRE(model_identify_image(image, parameters, (unsigned char*)&arena + 2) == MODEL_ERROR_ALIGNMENT);
  image[3] = (float)NAN;
  REQUIRE(model_identify_image(image, parameters, &arena) == MODEL_ERROR_NOT_FINITE);
  image[3] = pixel;
  REQUIRE(parameters[0] == 1 && parameters[6] == 7); /* untouched by all that */
#ifdef DEVIATIONS
  REQUIRE(model_stddevs(NULL, &arena) == MODEL_ERROR_NULL);
  REQUIRE(model_stddevs(parameters, NULL) == MODEL_ERROR_NULL);
  REQUIRE(model_stddevs(parameters, (unsigned char*)&arena + 4) == MODEL_ERROR_ALIGNMENT);
  REQUIRE(model_stddevs(parameters, &arena) == MODEL_ERROR_STATE); /* that image had no result */
#endif
#ifdef FAMILIARITY
  {
    double distance = 7.0;
    REQUIRE(model_distance(NULL, &arena) == MODEL_ERROR_NULL);
    REQUIRE(model_distance(&distance, NULL) == MODEL_ERROR_NULL);
    REQUIRE(model_distance(&distance, (unsigned char*)&arena + 4) == MODEL_ERROR_ALIGNMENT);
    REQUIRE(model_distance(&distance, &arena) == MODEL_ERROR_STATE);
    REQUIRE(distance == 7.0);
  }
#endif
  REQUIRE(model_self_test(NULL) == MODEL_ERROR_NULL);
  REQUIRE(model_self_test((unsigned char*)&arena + 1) == MODEL_ERROR_ALIGNMENT);
}

int main(int argc, char** argv) {
  FILE *sways, *images, *results;
  if (argc != 4) return 2;
  sways = fopen(argv[1], "rb");
  images = fopen(argv[2], "rb");
  results = fopen(argv[3], "wb");
  if (sways == NULL || images == NULL || results == NULL) return 2;
  REQUIRE(MODEL_PARAMETERS == 7 && sizeof arena == MODEL_ARENA_BYTES);
  check_after_self_test();
  while (fread(sway, sizeof sway, 1, sways) == 1) {
    float whole[RESULTS], other[RESULTS];
    REQUIRE(fread(image, sizeof image, 1, images) == 1);
    memset(&arena, 0xff, sizeof arena); /* what is in it must not matter: NaN all over */
    REQUIRE(model_identify(sway, whole, &arena) == MODEL_OK);
    add_rest(whole);
    REQUIRE(model_identify_image(image, other, &arena) == MODEL_OK);
    add_rest(other);
    REQUIRE(memcmp(whole, other, sizeof whole) == 0);
#ifdef INCREMENTAL
    REQUIRE(as_they_arrive(other, 110, 8) == MODEL_OK);
    REQUIRE(memcmp(whole, other, sizeof whole) == 0);
    REQUIRE(as_they_arrive(other, 1, 1) == MODEL_OK);
    REQUIRE(memcmp(whole, other, sizeof whole) == 0);
    REQUIRE(as_they_arrive(other, 7919, 0) == MODEL_OK); /* all work is left to feed, and to the end */
    REQUIRE(memcmp(whole, other, sizeof whole) == 0);
#endif
    REQUIRE(fwrite(whole, sizeof whole, 1, results) == 1);
  }
  check_large_pixels();
  check_errors();
#ifdef INCREMENTAL
  check_incremental_errors();
#endif
  REQUIRE(fclose(results) == 0);
  return (failures == 0) ? 0 : 1;
}
