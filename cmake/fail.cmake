# A test that cannot run fails: it says what it lacks.
message(FATAL_ERROR "${PROBLEM}")
