
/* The same as samples arrive. Call begin; then feed, with any number of samples at a time; work, one short unit per
   call, whenever there is time: DECID_FW_MORE means that another unit can run now, DECID_FW_OK that all is done or
   needs more samples; and result after all samples and all work (before, DECID_FW_ERROR_STATE). feed does the work
   that is left when it needs the memory, so the result never depends on the schedule, and one feed may do all of it: do
   not call it where that would take too long, as in an interrupt. Let that put its samples into a queue of your own. If one sample of a batch is
   infinite or NaN (DECID_FW_ERROR_NOT_FINITE), feed takes none of the batch: correct it and feed it again. */
int DECID_FW_begin(void *arena);
int DECID_FW_feed(const float *sway_rad, int count, void *arena);
int DECID_FW_work(void *arena);
int DECID_FW_result(float *parameters, void *arena);
