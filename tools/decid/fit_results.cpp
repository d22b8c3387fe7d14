// Fits as JSON and text: see fit_results.hpp.
#include "tools/decid/fit_results.hpp"

#include "base/json_object.hpp"
#include "base/text.hpp"
#include "tools/decid/results.hpp"

namespace decid::tools {

std::string fits_json(const std::string& model, const FittedRecordings& all) {
  Json recordings = Json::array();
  for (std::size_t i = 0; i < all.fits.size(); ++i) {
    const Identification& id = all.identified.recordings[i];
    Json& recording = recordings.emplace_back(recording_json(id, all.identified.protocol));
    if (id.error) continue;
    const FitFigures& fitted = all.fits[i];
    const fit::Result& result = fitted.result;
    for (std::size_t p = 0; p < result.standard_error.size(); ++p) {
      recording["parameters"][p]["standard_error"] = result.standard_error[p];
      recording["parameters"][p]["likeliest"] = result.likeliest[p];
    }
    Json& fit = recording["fit"];
    fit["cost"] = result.cost;
    fit["sensor_noise_deg"] = result.sensor_noise_deg;
    fit["start"] = fitted.start;
    fit["simulations"] = result.simulations;
    fit["effective_samples"] = result.effective_samples;
    fit["seconds"] = fitted.seconds;
  }
  return recordings_json(model, recordings);
}

std::string fits_text(const FittedRecordings& all) {
  std::string text;
  for (std::size_t i = 0; i < all.fits.size(); ++i) {
    const Identification& id = all.identified.recordings[i];
    const FitFigures& fitted = all.fits[i];
    if (id.error) {
      text += id.file + ": not fitted\n";
      continue;
    }
    const fit::Result& result = fitted.result;
    text += headline(id);
    text += format("  cost %.1f after %lld simulations in %.1f s, found from start %s; sensor noise %.2g degrees\n",
                   result.cost, result.simulations, fitted.seconds, fitted.start.c_str(), result.sensor_noise_deg);
    text += format("  %-8s %12s %10s %-10s %10s %12s%s  %s\n", "", "fitted", "+-", "unit", "/ (m g h)", "likeliest",
                   id.truth ? "         true" : "", "range");
    const sim::ParameterTable& table = all.identified.protocol.parameters();
    for (std::size_t p = 0; p < table.size(); ++p) {
      const sim::ParameterInfo& info = table[p];
      text += format("  %-8s %12.5g %10.3g %-10s ", info.name.c_str(), id.estimate.parameters[p],
                     result.standard_error[p], info.shown_unit().c_str());
      text += info.per_mgh ? format("%10.4f", id.estimate.parameters[p] / all.identified.protocol.experiment.body.mgh())
                           : std::string(10, ' ');
      text += format(" %12.5g", result.likeliest[p]);
      if (id.truth) text += format(" %12.5g", (*id.truth)[p]);
      text += format("  %g to %g\n", info.low, info.high);
    }
    for (const std::string& warning : id.warnings()) text += "  warning: " + warning + "\n";
  }
  return text;
}

}  // namespace decid::tools
