/* Forks of a process that has called libdecid: with one thread a child computes as its parent does, with several it is
   refused, and the remedies of that error are true. Each case is a process of its own, which no other call has given
   threads.
     fork_processes         runs all cases
     fork_processes CASE    runs one */
#include <decid/decid.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

enum { limit_s = 60 }; /* of each process: one that waits for threads would wait for ever */

static decid_model* model;
static decid_recording* recording;

#define REQUIRE(condition)                                                                                 \
  do {                                                                                                     \
    if (!(condition)) {                                                                                    \
      fprintf(stderr, "line %d: " #condition " is false; last error: %s\n", __LINE__, decid_error_text()); \
      _exit(1);                                                                                            \
    }                                                                                                      \
  } while (0)

static void make_trial(void) {
  const decid_protocol* protocol;
  double parameters[DECID_MAX_PARAMETERS];
  double* sway_rad;
  size_t p, samples;
  REQUIRE(decid_model_load(NULL, &model) == DECID_OK);
  protocol = decid_model_protocol(model);
  samples = decid_protocol_samples(protocol);
  for (p = 0; p < decid_protocol_parameters(protocol); ++p) {
    const decid_parameter_info* info = decid_protocol_parameter(protocol, p);
    parameters[p] = 0.5 * (info->low + info->high);
  }
  sway_rad = malloc(samples * sizeof *sway_rad);
  REQUIRE(sway_rad != NULL);
  REQUIRE(decid_simulate(protocol, parameters, 1, 7, sway_rad, NULL) == DECID_OK);
  REQUIRE(decid_recording_of(sway_rad, samples, decid_protocol_rate_hz(protocol), DECID_RADIANS, &recording) ==
          DECID_OK);
  free(sway_rad);
}

static double identified_kp(void) {
  decid_result* result = NULL;
  double kp;
  REQUIRE(decid_identify(model, recording, NULL, &result) == DECID_OK);
  kp = decid_result_parameter(result, 0)->value;
  decid_result_free(result);
  return kp;
}

static void require_success(pid_t child) {
  int how = -1;
  REQUIRE(child > 0);
  REQUIRE(waitpid(child, &how, 0) == child);
  REQUIRE(WIFEXITED(how));
  REQUIRE(WEXITSTATUS(how) == 0);
}

/* A child has the parent's bits with its one thread, and with threads of its own. */
static void require_child_computes(void) {
  const double kp = identified_kp();
  const pid_t child = fork();
  if (child == 0) {
    alarm(limit_s);
    REQUIRE(identified_kp() == kp);
    REQUIRE(decid_set_threads(2) == DECID_OK);
    REQUIRE(identified_kp() == kp);
    _exit(0);
  }
  require_success(child);
  REQUIRE(identified_kp() == kp);
}

static void require_child_is_refused(void) {
  const double kp = identified_kp();
  const pid_t child = fork();
  if (child == 0) {
    decid_result* result = NULL;
    alarm(limit_s);
    REQUIRE(decid_identify(model, recording, NULL, &result) == DECID_BAD_INPUT);
    REQUIRE(result == NULL);
    REQUIRE(strcmp(decid_error_code(), "not_supported") == 0);
    REQUIRE(strstr(decid_error_problem(), "forked") != NULL);
    REQUIRE(strstr(decid_error_remedy(), "set_threads(1) the first call") != NULL);
    REQUIRE(strstr(decid_error_remedy(), "OMP_NUM_THREADS=1") != NULL);
    REQUIRE(decid_set_threads(1) == DECID_BAD_INPUT); /* too late */
    REQUIRE(strcmp(decid_error_code(), "not_supported") == 0);
    _exit(0);
  }
  require_success(child);
  REQUIRE(identified_kp() == kp); /* the parent goes on */
}

static void set_one_thread_first(void) {
  REQUIRE(decid_set_threads(0) == DECID_BAD_INPUT); /* this one sets nothing, and starts nothing */
  REQUIRE(decid_set_threads(1) == DECID_OK);
  make_trial();
  require_child_computes();
}

static void set_one_thread_in_environment(void) {
  make_trial();
  require_child_computes();
}

static void set_several_threads(void) {
  REQUIRE(decid_set_threads(2) == DECID_OK);
  make_trial();
  require_child_is_refused();
}

static void set_one_thread_too_late(void) {
  REQUIRE(decid_set_threads(2) == DECID_OK);
  make_trial();
  identified_kp();
  REQUIRE(decid_set_threads(1) == DECID_OK);
  require_child_is_refused();
}

static const struct {
  const char* name;
  const char* threads; /* OMP_NUM_THREADS */
  void (*run)(void);
} cases[] = {
    {"one_thread_first", "2", set_one_thread_first},
    {"one_thread_in_environment", "1", set_one_thread_in_environment},
    {"several_threads", "2", set_several_threads},
    {"one_thread_too_late", "2", set_one_thread_too_late},
};

int main(int count, char** arguments) {
  size_t i;
  for (i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    if (count == 2 && strcmp(arguments[1], cases[i].name) == 0) {
      alarm(3 * limit_s);
      cases[i].run();
      decid_recording_free(recording);
      decid_model_free(model);
      return 0;
    }
    if (count == 1) {
      const pid_t child = fork();
      if (child == 0) {
        setenv("OMP_NUM_THREADS", cases[i].threads, 1);
        execl("/proc/self/exe", arguments[0], cases[i].name, (char*)NULL);
        _exit(1);
      }
      printf("%s\n", cases[i].name);
      fflush(stdout);
      require_success(child);
    }
  }
  return count == 1 ? 0 : 2;
}
