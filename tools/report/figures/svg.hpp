// Figures as SVG 1.1, drawn by the program: a sheet of shapes in pixels, and plots on it in the data's coordinates.
// Text is escaped. The same numbers give the same bytes.
#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "tools/report/figures/png.hpp"

namespace decid::tools {

/// A figure as a drawing and as a table of its numbers.
struct Figure {
  std::string id;  ///< its files are id.svg and id.csv
  std::string title, caption;
  std::string svg, csv;
};

enum class Anchor { start, middle, end };

class Sheet {
 public:
  Sheet(double width, double height);

  struct Pen {
    std::string colour;
    double width = 1.4;
    bool dashed = false;
  };
  struct Point {
    double x, y;
  };
  void line(Point from, Point to, const Pen& pen);
  void path(std::span<const Point> points, const Pen& pen);
  /// Fills the shape between the points, a quarter opaque.
  void area(std::span<const Point> points, const std::string& fill);
  void box(Point corner, double width, double height, const std::string& fill);
  void frame(Point corner, double width, double height, const Pen& pen);
  void dot(Point centre, double radius, const std::string& fill);
  void text(Point at, const std::string& text, Anchor anchor, double size = 12, bool upwards = false,
            const std::string& colour = "#1c2733");
  /// Pixels stay sharp.
  void bitmap(Point corner, double width, double height, const Bitmap& pixels);
  /// A row of names with their colours, from `at` to the right.
  void legend(Point at, const std::vector<std::pair<std::string, std::string>>& names_and_colours);

  std::string svg() const;

 private:
  double width_, height_;
  std::string body_;
};

/// An axis of a plot: linear, logarithmic, or names at 0, 1, 2, ...
struct PlotAxis {
  std::string title;
  double low = 0, high = 1;
  bool logarithmic = false;
  std::vector<std::string> names = {};
};
/// Returns limits that include all finite values with a margin, and 0 if requested; [0, 1] if there are no finite
/// values.
PlotAxis axis_for(std::string title, const std::vector<std::span<const double>>& values, bool with_zero);

/// Axes on a sheet. Values that are not finite leave a gap; lines are cut at the frame.
class Plot {
 public:
  /// The frame of `width` x `height` begins at `corner`; titles and numbers stand outside, left and below.
  Plot(Sheet& sheet, Sheet::Point corner, double width, double height, PlotAxis x, PlotAxis y,
       const std::string& title = "");

  void line(std::span<const double> x, std::span<const double> y, const Sheet::Pen& pen);
  /// Fills between the lines `low` and `high`, which must be finite.
  void band(std::span<const double> x, std::span<const double> low, std::span<const double> high,
            const std::string& colour);
  /// Draws a signal of many samples: the extremes of each pixel.
  void signal(std::span<const double> x, std::span<const double> y, const Sheet::Pen& pen);
  void dots(std::span<const double> x, std::span<const double> y, const std::string& colour);
  /// From 0 to height, between the values left and right of the x axis.
  void bar(double left, double right, double height, const std::string& colour);
  void upright(double x, const std::string& name, const std::string& colour);

 private:
  double to_x(double x) const;
  double to_y(double y) const;
  void ticks();

  Sheet& sheet_;
  Sheet::Point corner_;
  double width_, height_;
  PlotAxis x_, y_;
};

}  // namespace decid::tools
