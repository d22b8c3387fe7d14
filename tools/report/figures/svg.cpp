// Figures as SVG: see svg.hpp.
#include "tools/report/figures/svg.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"

namespace decid::tools {
namespace {

constexpr const char* ink = "#3d4853";
constexpr const char* grid = "#e6eaee";

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : valid_utf8(text)) {
    if (c == '<')
      safe += "&lt;";
    else if (c == '>')
      safe += "&gt;";
    else if (c == '&')
      safe += "&amp;";
    else if (c == '"')
      safe += "&quot;";
    else if (static_cast<unsigned char>(c) < ' ' || c == '\x7f')
      safe += '?';
    else
      safe += c;
  }
  return safe;
}

std::string stroke(const Sheet::Pen& pen) {
  return format("fill=\"none\" stroke=\"%s\" stroke-width=\"%.4g\" stroke-linejoin=\"round\"%s", pen.colour.c_str(),
                pen.width, pen.dashed ? " stroke-dasharray=\"6 4\"" : "");
}

/// 1, 2 or 5 times a power of ten, about `span` / `wanted`.
double step_for(double span, double wanted) {
  const double rough = span / wanted, power = std::pow(10.0, std::floor(std::log10(rough)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= rough * (1 - 1e-9)) return factor * power;
  return 10 * power;
}

std::vector<double> tick_values(const PlotAxis& axis, double length) {
  std::vector<double> values;
  if (!axis.names.empty()) {
    for (std::size_t i = 0; i < axis.names.size(); ++i) values.push_back(static_cast<double>(i));
  } else if (axis.logarithmic) {
    for (int power = -12; power <= 12; ++power)
      for (const double factor : {1.0, 2.0, 5.0}) {
        const double value = factor * std::pow(10.0, power);
        if (value >= axis.low * 0.999 && value <= axis.high * 1.001) values.push_back(value);
      }
  } else {
    const double step = step_for(axis.high - axis.low, std::max(2.0, length / 60));
    for (double k = std::ceil(axis.low / step - 1e-9); k * step <= axis.high + 1e-9 * step; ++k)
      values.push_back(k == 0 ? 0 : k * step);  // no -0
  }
  return values;
}

double place(const PlotAxis& axis, double value) {
  if (axis.logarithmic) return std::log(value / axis.low) / std::log(axis.high / axis.low);
  return (value - axis.low) / (axis.high - axis.low);
}

}  // namespace

Sheet::Sheet(double width, double height) : width_(width), height_(height) {}

void Sheet::line(Point from, Point to, const Pen& pen) {
  body_ += format("<path d=\"M%.2f %.2fL%.2f %.2f\" %s/>\n", from.x, from.y, to.x, to.y, stroke(pen).c_str());
}

void Sheet::path(std::span<const Point> points, const Pen& pen) {
  if (points.size() < 2) return;
  std::string d;
  for (const Point& p : points) d += format("%c%.2f %.2f", d.empty() ? 'M' : 'L', p.x, p.y);
  body_ += "<path d=\"" + d + "\" " + stroke(pen) + "/>\n";
}

void Sheet::area(std::span<const Point> points, const std::string& fill) {
  std::string d;
  for (const Point& p : points) d += format("%c%.2f %.2f", d.empty() ? 'M' : 'L', p.x, p.y);
  body_ += "<path d=\"" + d + "Z\" fill=\"" + fill + "\" fill-opacity=\"0.25\"/>\n";
}

void Sheet::box(Point corner, double width, double height, const std::string& fill) {
  body_ += format("<rect x=\"%.2f\" y=\"%.2f\" width=\"%.2f\" height=\"%.2f\" fill=\"%s\"/>\n", corner.x, corner.y,
                  width, height, fill.c_str());
}

void Sheet::frame(Point corner, double width, double height, const Pen& pen) {
  body_ += format("<rect x=\"%.2f\" y=\"%.2f\" width=\"%.2f\" height=\"%.2f\" %s/>\n", corner.x, corner.y, width,
                  height, stroke(pen).c_str());
}

void Sheet::dot(Point centre, double radius, const std::string& fill) {
  body_ +=
      format("<circle cx=\"%.2f\" cy=\"%.2f\" r=\"%.2f\" fill=\"%s\"/>\n", centre.x, centre.y, radius, fill.c_str());
}

void Sheet::text(Point at, const std::string& text, Anchor anchor, double size, bool upwards,
                 const std::string& colour) {
  constexpr const char* anchors[] = {"start", "middle", "end"};
  const std::string turn = upwards ? format(" transform=\"rotate(-90 %.2f %.2f)\"", at.x, at.y) : "";
  body_ += format("<text x=\"%.2f\" y=\"%.2f\" font-size=\"%.3g\" text-anchor=\"%s\" fill=\"%s\"%s>", at.x, at.y, size,
                  anchors[static_cast<int>(anchor)], colour.c_str(), turn.c_str()) +
           escaped(text) + "</text>\n";
}

void Sheet::bitmap(Point corner, double width, double height, const Bitmap& pixels) {
  body_ += format(
               "<image x=\"%.2f\" y=\"%.2f\" width=\"%.2f\" height=\"%.2f\" preserveAspectRatio=\"none\" "
               "style=\"image-rendering:pixelated\" href=\"data:image/png;base64,",
               corner.x, corner.y, width, height) +
           base64(png(pixels)) + "\"/>\n";
}

void Sheet::legend(Point at, const std::vector<std::pair<std::string, std::string>>& names_and_colours) {
  for (const auto& [name, colour] : names_and_colours) {
    box({at.x, at.y - 9}, 16, 9, colour);
    text({at.x + 21, at.y}, name, Anchor::start);
    at.x += 45 + 6.6 * static_cast<double>(name.size());
  }
}

std::string Sheet::svg() const {
  return format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" viewBox=\"0 0 %.0f %.0f\" "
             "font-family=\"system-ui, 'Liberation Sans', sans-serif\">\n"
             "<rect width=\"100%%\" height=\"100%%\" fill=\"#ffffff\"/>\n",
             width_, height_, width_, height_) +
         body_ + "</svg>\n";
}

PlotAxis axis_for(std::string title, const std::vector<std::span<const double>>& values, bool with_zero) {
  double low = 0, high = 0;
  bool any = with_zero;
  for (const auto& list : values)
    for (const double value : list) {
      if (!std::isfinite(value)) continue;
      low = any ? std::min(low, value) : value;
      high = any ? std::max(high, value) : value;
      any = true;
    }
  if (!any) return {std::move(title)};
  const double room = high > low ? 0.05 * (high - low) : 0.5 * std::max(std::abs(high), 1e-3);
  return {std::move(title), with_zero && low == 0 ? 0 : low - room,
          with_zero && high == 0 && low < 0 ? 0 : high + room};
}

Plot::Plot(Sheet& sheet, Sheet::Point corner, double width, double height, PlotAxis x, PlotAxis y,
           const std::string& title)
    : sheet_(sheet), corner_(corner), width_(width), height_(height), x_(std::move(x)), y_(std::move(y)) {
  ticks();
  sheet_.frame(corner_, width_, height_, {ink, 1});
  sheet_.text({corner_.x + width_ / 2, corner_.y + height_ + 36}, x_.title, Anchor::middle);
  sheet_.text({corner_.x - 46, corner_.y + height_ / 2}, y_.title, Anchor::middle, 12, true);
  if (!title.empty()) sheet_.text({corner_.x + 2, corner_.y - 7}, title, Anchor::start, 13);
}

double Plot::to_x(double x) const {
  return corner_.x + width_ * std::clamp(place(x_, x), 0.0, 1.0);
}

double Plot::to_y(double y) const {
  return corner_.y + height_ * (1 - std::clamp(place(y_, y), 0.0, 1.0));
}

void Plot::ticks() {
  const double bottom = corner_.y + height_;
  for (const double value : tick_values(x_, width_)) {
    const std::string name = x_.names.empty() ? format("%.6g", value) : x_.names[static_cast<std::size_t>(value)];
    if (x_.names.empty()) sheet_.line({to_x(value), corner_.y}, {to_x(value), bottom}, {grid, 1});
    sheet_.text({to_x(value), bottom + 17}, name, Anchor::middle, 12, false, ink);
  }
  for (const double value : tick_values(y_, 1.6 * height_)) {
    sheet_.line({corner_.x, to_y(value)}, {corner_.x + width_, to_y(value)}, {grid, 1});
    sheet_.text({corner_.x - 6, to_y(value) + 4}, format("%.6g", value), Anchor::end, 12, false, ink);
  }
}

void Plot::line(std::span<const double> x, std::span<const double> y, const Sheet::Pen& pen) {
  std::vector<Sheet::Point> points;
  for (std::size_t i = 0; i <= y.size(); ++i) {
    if (i < y.size() && std::isfinite(y[i])) {
      points.push_back({to_x(x[i]), to_y(y[i])});
      continue;
    }
    sheet_.path(points, pen);
    points.clear();
  }
}

void Plot::band(std::span<const double> x, std::span<const double> low, std::span<const double> high,
                const std::string& colour) {
  std::vector<Sheet::Point> points;
  for (std::size_t i = 0; i < x.size(); ++i) points.push_back({to_x(x[i]), to_y(low[i])});
  for (std::size_t i = x.size(); i-- > 0;) points.push_back({to_x(x[i]), to_y(high[i])});
  sheet_.area(points, colour);
}

void Plot::signal(std::span<const double> x, std::span<const double> y, const Sheet::Pen& pen) {
  const std::size_t columns = std::max<std::size_t>(1, static_cast<std::size_t>(width_));
  if (y.size() <= 4 * columns) {
    line(x, y, pen);
    return;
  }
  std::vector<double> kept_x, kept_y;
  for (std::size_t c = 0; c < columns; ++c) {
    const auto begin = y.begin() + static_cast<std::ptrdiff_t>(y.size() * c / columns);
    const auto end = y.begin() + static_cast<std::ptrdiff_t>(y.size() * (c + 1) / columns);
    const auto [low, high] = std::minmax_element(begin, end);
    for (const auto at : {std::min(low, high), std::max(low, high)}) {
      kept_x.push_back(x[static_cast<std::size_t>(at - y.begin())]);
      kept_y.push_back(*at);
    }
  }
  line(kept_x, kept_y, pen);
}

void Plot::dots(std::span<const double> x, std::span<const double> y, const std::string& colour) {
  for (std::size_t i = 0; i < y.size(); ++i)
    if (std::isfinite(y[i])) sheet_.dot({to_x(x[i]), to_y(y[i])}, 3, colour);
}

void Plot::bar(double left, double right, double height, const std::string& colour) {
  if (!std::isfinite(height)) return;
  const double top = std::min(to_y(height), to_y(0)), bottom = std::max(to_y(height), to_y(0));
  sheet_.box({to_x(left), top}, to_x(right) - to_x(left), bottom - top, colour);
}

void Plot::upright(double x, const std::string& name, const std::string& colour) {
  sheet_.line({to_x(x), corner_.y}, {to_x(x), corner_.y + height_}, {colour, 1.6, true});
  sheet_.text({to_x(x) + 5, corner_.y + 15}, name, Anchor::start, 12, false, colour);
}

}  // namespace decid::tools
