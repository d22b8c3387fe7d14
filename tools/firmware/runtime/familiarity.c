/* ---- How far the trial is from the training trials ------------------------------------------------------------------
   As identify/network/ood_detector.hpp: the features, which lie where the last layer reads them, whitened. */

static int32_t take_distance(void* arena, double* distance) {
  const network_map* const map = &network_maps[network_layers[LAYERS - 1].src];
  const float* const features = &maps_of(arena)[map->offset];
  double squares = 0.0;
  int32_t next = 0;
  int32_t i;
  int32_t j;
  const int32_t result = check_outputs(state_of(arena));
  if (result != DECID_FW_OK) {
    return result;
  }
  for (i = 0; i < FEATURES; ++i) {
    double sum = 0.0;
    for (j = 0; j <= i; ++j) {
      sum = sum + ((double)familiarity_whitening[next] * ((double)features[j] - (double)familiarity_mean[j]));
      ++next;
    }
    squares = squares + (sum * sum);
  }
  if (is_finite(squares) == 0) {
    return DECID_FW_ERROR_NOT_FINITE;
  }
  *distance = square_root(squares / (double)FEATURES) / FAMILIARITY_USUAL;
  return DECID_FW_OK;
}

int DECID_FW_distance(double* distance, void* arena) {
  int32_t result = check_arena(arena);
  if (distance == NULL) {
    result = DECID_FW_ERROR_NULL;
  }
  if (result == DECID_FW_OK) {
    result = take_distance(arena, distance);
  }
  return (int)result;
}
