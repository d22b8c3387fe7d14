// Figures: where shapes stand on the sheet and data in a plot, that text stays text, gaps gaps and extremes extremes.
#include "tools/report/figures/svg.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdio>
#include <limits>

namespace decid::tools {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// Returns the text that `draw` adds to an empty sheet.
template <class Draw>
std::string drawn(const Draw& draw) {
  Sheet sheet(300, 200);
  const std::string empty = sheet.svg();
  draw(sheet);
  const std::string svg = sheet.svg(), end = "</svg>\n";
  const std::string before = empty.substr(0, empty.size() - end.size());
  REQUIRE(svg.starts_with(before));
  REQUIRE(svg.ends_with(end));
  return svg.substr(before.size(), svg.size() - before.size() - end.size());
}

/// Returns the text that `draw` adds to a plot whose frame is 200 x 100 pixels at (50, 20).
template <class Draw>
std::string plotted(PlotAxis x, PlotAxis y, const Draw& draw) {
  Sheet bare(300, 200), sheet(300, 200);
  Plot(bare, {50, 20}, 200, 100, x, y);
  Plot plot(sheet, {50, 20}, 200, 100, x, y);
  draw(plot);
  const std::string frame = bare.svg(), svg = sheet.svg(), end = "</svg>\n";
  REQUIRE(svg.starts_with(frame.substr(0, frame.size() - end.size())));
  return svg.substr(frame.size() - end.size(), svg.size() - frame.size());
}

struct Point {
  double x, y;
};
/// The points of the paths in an SVG.
std::vector<std::vector<Point>> paths_of(const std::string& svg) {
  std::vector<std::vector<Point>> paths;
  for (std::size_t at = svg.find("d=\"M"); at != std::string::npos; at = svg.find("d=\"M", at + 1)) {
    paths.emplace_back();
    const char* next = svg.c_str() + at + 3;
    double x = 0, y = 0;
    int taken = 0;
    while (std::sscanf(next, "%*[ML]%lf %lf%n", &x, &y, &taken) == 2) {
      paths.back().push_back({x, y});
      next += taken;
    }
    CHECK(*next == '"');
  }
  return paths;
}

}  // namespace

TEST_CASE("svg: a sheet says its size, and shapes stand where they were put") {
  CHECK(has(Sheet(300, 200).svg(), "width=\"300\" height=\"200\" viewBox=\"0 0 300 200\""));
  CHECK(drawn([](Sheet& s) {
          s.line({1, 2.5}, {3, 4}, {"#ff0000", 2});
        }) ==
        "<path d=\"M1.00 2.50L3.00 4.00\" fill=\"none\" stroke=\"#ff0000\" stroke-width=\"2\" "
        "stroke-linejoin=\"round\"/>\n");
  CHECK(has(drawn([](Sheet& s) { s.line({1, 2}, {3, 4}, {"#ff0000", 2, true}); }), "stroke-dasharray"));
  const std::vector<Sheet::Point> points{{1, 2}, {3, 4}, {5, 0}};
  CHECK(has(drawn([&](Sheet& s) { s.path(points, {"#000000"}); }), "d=\"M1.00 2.00L3.00 4.00L5.00 0.00\""));
  CHECK(drawn([&](Sheet& s) { s.path(std::span(points).first(1), {"#000000"}); }).empty());
  CHECK(drawn([](Sheet& s) {
          s.box({1, 2}, 30, 40, "#00ff00");
        }) == "<rect x=\"1.00\" y=\"2.00\" width=\"30.00\" height=\"40.00\" fill=\"#00ff00\"/>\n");
  const std::string frame = drawn([](Sheet& s) { s.frame({1, 2}, 30, 40, {"#0000ff"}); });
  CHECK(has(frame, "x=\"1.00\" y=\"2.00\" width=\"30.00\" height=\"40.00\" fill=\"none\" stroke=\"#0000ff\""));
  CHECK(drawn([](Sheet& s) {
          s.dot({7, 8}, 3, "#123456");
        }) == "<circle cx=\"7.00\" cy=\"8.00\" r=\"3.00\" fill=\"#123456\"/>\n");
}

TEST_CASE("svg: text is anchored, turned and escaped") {
  const auto text = [](const std::string& content, Anchor anchor, bool upwards) {
    return drawn([&](Sheet& s) { s.text({10, 20}, content, anchor, 9, upwards, "#abcdef"); });
  };
  CHECK(text("sway", Anchor::start, false) ==
        "<text x=\"10.00\" y=\"20.00\" font-size=\"9\" text-anchor=\"start\" fill=\"#abcdef\">sway</text>\n");
  CHECK(has(text("sway", Anchor::middle, false), "text-anchor=\"middle\""));
  CHECK(has(text("sway", Anchor::end, true),
            "text-anchor=\"end\" fill=\"#abcdef\" transform=\"rotate(-90 10.00 20.00)\""));
  CHECK(has(text("<b>&\"\xffx\n", Anchor::start, false), ">&lt;b&gt;&amp;&quot;\xEF\xBF\xBDx?</text>\n"));
  CHECK(has(text("M\u00FCller", Anchor::start, false), ">M\u00FCller</text>\n"));
  // The names of a legend stand one after another, each beside its colour.
  const std::string legend = drawn([](Sheet& s) { s.legend({10, 30}, {{"one", "#111111"}, {"three", "#333333"}}); });
  CHECK(has(legend, "<text x=\"31.00\""));
  CHECK(has(legend,
            "<rect x=\"74.80\" y=\"21.00\" width=\"16.00\" height=\"9.00\" fill=\"#333333\"/>\n<text x=\"95.80\""));
  CHECK(has(legend, ">three</text>"));
}

TEST_CASE("svg: a bitmap is a PNG in its place, sharp") {
  Bitmap bitmap(2, 1, 1);
  bitmap.at(0, 1) = 7;
  const std::string image = drawn([&](Sheet& s) { s.bitmap({1, 2}, 30, 40, bitmap); });
  CHECK(image.starts_with("<image x=\"1.00\" y=\"2.00\" width=\"30.00\" height=\"40.00\""));
  CHECK(has(image, "pixelated"));
  CHECK(has(image, "href=\"data:image/png;base64," + base64(png(bitmap)) + "\""));
}

TEST_CASE("svg: axes hold all finite values and a twentieth of room, 0 if asked for") {
  const std::vector<double> a{1, nan, 3}, b{11, std::numeric_limits<double>::infinity()}, same{2, 2}, none{nan};
  const auto limits = [](const PlotAxis& axis) { return std::pair(axis.low, axis.high); };
  CHECK(limits(axis_for("t", {a, b}, false)) == std::pair(0.5, 11.5));
  CHECK(axis_for("t", {a, b}, false).title == "t");
  CHECK(limits(axis_for("t", {b}, true)) == std::pair(0.0, 11 + 0.05 * 11));
  const std::vector<double> negative{-10, -5};
  CHECK(limits(axis_for("t", {negative}, true)) == std::pair(-10.5, 0.0));
  CHECK(limits(axis_for("t", {same}, false)) == std::pair(1.0, 3.0));  // a constant is in the middle
  CHECK(limits(axis_for("t", {none}, false)) == std::pair(0.0, 1.0));
  CHECK(limits(axis_for("t", {}, false)) == std::pair(0.0, 1.0));
}

TEST_CASE("svg: data stand in the frame by their axes, and are cut at it") {
  const PlotAxis linear{"x", 0, 4}, unit{"y", 0, 1}, logarithmic{"f", 0.1, 10, true},
      names{"p", -0.5, 2.5, false, {"a", "b", "c"}};
  const std::vector<double> y{0, 1, -5, 7, 0.25};
  const std::vector<double> x{0, 1, 2, 9, -1};
  const auto line = paths_of(plotted(linear, unit, [&](Plot& p) { p.line(x, y, {"#123456"}); }));
  REQUIRE(line.size() == 1);
  const std::vector<Point> expected{{50, 120}, {100, 20}, {150, 120}, {250, 20}, {50, 95}};
  REQUIRE(line[0].size() == expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    CHECK(line[0][i].x == expected[i].x);
    CHECK(line[0][i].y == expected[i].y);
  }
  const std::vector<double> decades{0.1, 1, 10}, middle{0.5, 0.5, nan};
  const std::string dots = plotted(logarithmic, unit, [&](Plot& p) { p.dots(decades, middle, "#123456"); });
  CHECK(has(dots, "cx=\"50.00\" cy=\"70.00\""));
  CHECK(has(dots, "cx=\"150.00\" cy=\"70.00\""));
  CHECK_FALSE(has(dots, "cx=\"250.00\""));  // its y is none
  // A bar from 0, up or down; names stand at 0, 1, 2.
  const PlotAxis both{"y", -1, 1};
  CHECK(plotted(names, both, [](Plot& p) { p.bar(0.5, 1.5, 0.5, "#1"); }) ==
        "<rect x=\"116.67\" y=\"45.00\" width=\"66.67\" height=\"25.00\" fill=\"#1\"/>\n");
  CHECK(has(plotted(names, both, [](Plot& p) { p.bar(0.5, 1.5, -0.5, "#1"); }),
            "y=\"70.00\" width=\"66.67\" height=\"25.00\""));
  CHECK(plotted(names, both, [](Plot& p) { p.bar(0.5, 1.5, nan, "#1"); }).empty());
  const std::string upright = plotted(linear, unit, [](Plot& p) { p.upright(1, "here", "#1"); });
  CHECK(has(upright, "d=\"M100.00 20.00L100.00 120.00\""));
  CHECK(has(upright, ">here</text>"));
}

TEST_CASE("svg: gaps stay gaps, and nothing drawn is not a number") {
  const std::vector<double> x{0, 1, 2, 3, 4, 5, 6}, y{0, 1, nan, 0, 1, nan, 1};
  const std::string svg = plotted({"x", 0, 4}, {"y", 0, 1}, [&](Plot& p) { p.line(x, y, {"#123456"}); });
  const auto paths = paths_of(svg);
  REQUIRE(paths.size() == 2);  // a point alone is no line
  CHECK(paths[0].size() == 2);
  CHECK(paths[1].size() == 2);
  CHECK(paths[1][0].x == 200);
  CHECK_FALSE(has(svg, "nan"));
}

TEST_CASE("svg: a long signal keeps the extremes of each pixel") {
  std::vector<double> x, y;
  for (int k = 0; k < 100'000; ++k) {
    x.push_back(k);
    y.push_back(0.5);
  }
  y[54'321] = 1;
  y[54'322] = 0;
  const auto paths = paths_of(plotted({"x", 0, 100'000}, {"y", 0, 1}, [&](Plot& p) { p.signal(x, y, {"#123456"}); }));
  REQUIRE(paths.size() == 1);
  CHECK(paths[0].size() == 400);  // two a pixel
  int high = 0, low = 0;
  for (std::size_t i = 0; i < paths[0].size(); ++i) {
    if (i > 0) CHECK(paths[0][i].x >= paths[0][i - 1].x);
    const bool at_spike = std::abs(paths[0][i].x - (50 + 200 * 0.54321)) < 0.01;
    high += paths[0][i].y == 20 && at_spike;
    low += paths[0][i].y == 120 && at_spike;
  }
  CHECK(high == 1);
  CHECK(low == 1);
  // A short one is drawn as it is.
  const auto whole = paths_of(plotted({"x", 0, 800}, {"y", 0, 1}, [&](Plot& p) {
    p.signal(std::span(x).first(800), std::span(y).first(800), {"#123456"});
  }));
  CHECK(whole[0].size() == 800);
}

TEST_CASE("svg: ticks are 1, 2 or 5 times a power of ten, 0 without a sign") {
  const auto numbers = [](PlotAxis x) {
    Sheet sheet(300, 200);
    Plot(sheet, {50, 20}, 200, 100, std::move(x), {"", 0.5, 0.6});
    // The numbers of the x axis stand 17 pixels below the frame.
    const std::string svg = sheet.svg();
    std::vector<std::string> found;
    for (std::size_t at = svg.find("y=\"137.00\""); at != std::string::npos; at = svg.find("y=\"137.00\"", at + 1)) {
      const std::size_t begin = svg.find('>', at) + 1;
      found.push_back(svg.substr(begin, svg.find('<', begin) - begin));
    }
    return found;
  };
  using Numbers = std::vector<std::string>;
  CHECK(numbers({"", 0, 1}) == Numbers{"0", "0.5", "1"});
  CHECK(numbers({"", -1, 1}) == Numbers{"-1", "0", "1"});
  CHECK(numbers({"", -0.3, 0.31}) == Numbers{"-0.2", "0", "0.2"});
  CHECK(numbers({"", 1000, 9000}) == Numbers{"5000"});
  CHECK(numbers({"", 0.1, 10, true}) == Numbers{"0.1", "0.2", "0.5", "1", "2", "5", "10"});
  CHECK(numbers({"", -0.5, 1.5, false, {"Kp", "Kd"}}) == Numbers{"Kp", "Kd"});
}

}  // namespace decid::tools
