
/* The same as samples arrive. begin; feed, as often and as many samples at a time as suits; work, one short unit of it
   a call, whenever there is time: DECID_FW_MORE says that another unit can be done now, DECID_FW_OK that samples are
   waited for or all is done; result, once all samples are fed and all work is done (DECID_FW_ERROR_STATE before).
   What work was left undone feed does itself when it needs the memory, so the result never depends on the schedule. */
int DECID_FW_begin(void *arena);
int DECID_FW_feed(const float *sway_rad, int count, void *arena);
int DECID_FW_work(void *arena);
int DECID_FW_result(float *parameters, void *arena);
