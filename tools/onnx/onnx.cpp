// A network as ONNX: see onnx.hpp. Field numbers are onnx.proto's.
#include "tools/onnx/onnx.hpp"

#include <initializer_list>
#include <map>
#include <utility>
#include <variant>
#include <vector>

#include "base/error.hpp"
#include "base/version.hpp"
#include "nn/network_file.hpp"
#include "nn/operation.hpp"
#include "tools/onnx/protobuf.hpp"

namespace decid::tools {
namespace {

constexpr long long ir_version = 8, operators_version = 13;
constexpr long long type_float = 1, type_int64 = 7;                              // TensorProto.DataType
constexpr long long attribute_float = 1, attribute_int = 2, attribute_ints = 7;  // AttributeProto.AttributeType

Message float_attribute(std::string_view name, double value) {
  return Message().add(1, name).add(2, static_cast<float>(value)).add(20, attribute_float);
}
Message int_attribute(std::string_view name, long long value) {
  return Message().add(1, name).add(3, value).add(20, attribute_int);
}
Message ints_attribute(std::string_view name, std::initializer_list<long long> values) {
  Message attribute = Message().add(1, name);
  for (const long long value : values) attribute.add(8, value);
  return attribute.add(20, attribute_ints);
}

template <class Value>
Message tensor(const std::string& name, const std::vector<int>& shape, const std::vector<Value>& values,
               long long type) {
  Message made;
  for (const int extent : shape) made.add(1, static_cast<long long>(extent));
  return made.add(2, type)
      .add(8, std::string_view(name))
      .add(9, std::string_view(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value)));
}

/// Trials, then the extents.
Message float_values(std::string_view name, std::initializer_list<int> extents) {
  Message shape = Message().add(1, Message().add(2, std::string_view("trials")));
  for (const int extent : extents) shape.add(1, Message().add(1, static_cast<long long>(extent)));
  return Message().add(1, name).add(2, Message().add(1, Message().add(1, type_float).add(2, shape)));
}

/// The graph, layer after layer; each node reads the output of the one before.
class Graph {
 public:
  explicit Graph(const nn::Network<float>& network) {
    const nn::Shape in = network.input_shape();
    graph_.add(2, std::string_view("decid"));
    graph_.add(11, float_values("images", {in.channels, in.rows, in.columns}));
    std::size_t line = 0;
    for (const nn::Layer<float>& layer : network.layers()) {
      prefix_ = "layers." + std::to_string(line) + ".";
      line += layer.lines();
      for (const nn::Parameter<float>& p : layer.parameters())
        graph_.add(5, tensor(prefix_ + p.name, p.shape, p.value, type_float));
      for (const nn::RunningStatistics<float>& s : layer.statistics())
        graph_.add(5, tensor(prefix_ + s.name, {static_cast<int>(s.value.size())}, s.value, type_float));
      std::visit([&](const auto& kind) { add(kind); }, layer.kind());
    }
    if (!flat_) node("Flatten", {}, {int_attribute("axis", 1)});
    graph_.add(1, Message()
                      .add(1, std::string_view(last_))
                      .add(2, std::string_view("outputs"))
                      .add(4, std::string_view("Identity")));
    graph_.add(12, float_values("outputs", {static_cast<int>(network.output_shape().size())}));
  }

  const Message& message() const { return graph_; }

 private:
  /// Adds a node that reads `inputs` and writes last_.
  void add_node(std::string_view type, const std::vector<std::string>& inputs,
                std::initializer_list<Message> attributes) {
    const std::string output = "values." + std::to_string(nodes_++);
    Message node;
    for (const std::string& input : inputs) node.add(1, std::string_view(input));
    node.add(2, std::string_view(output)).add(3, std::string_view("node." + output)).add(4, type);
    for (const Message& attribute : attributes) node.add(5, attribute);
    graph_.add(1, node);
    last_ = output;
  }
  /// Adds a node that reads last_ first, then tensors of the layer.
  void node(std::string_view type, std::initializer_list<const char*> tensors,
            std::initializer_list<Message> attributes = {}) {
    std::vector<std::string> inputs{last_};
    for (const char* name : tensors) inputs.push_back(prefix_ + name);
    add_node(type, inputs, attributes);
  }

  /// After a fully connected layer there are no rows and columns; layers that need them get one of each.
  void need_planes() {
    if (!flat_) return;
    graph_.add(5, tensor(prefix_ + "planes", {4}, std::vector<std::int64_t>{0, -1, 1, 1}, type_int64));
    node("Reshape", {"planes"});
    flat_ = false;
  }

  void add(const nn::Conv2d& layer) {
    need_planes();
    const nn::Conv2dShape& s = layer.shape;
    node("Conv", {"weight", "bias"},
         {ints_attribute("kernel_shape", {s.kernel_rows, s.kernel_columns}),
          ints_attribute("strides", {s.stride_rows, s.stride_columns}),
          ints_attribute("pads", {s.pad_rows, s.pad_columns, s.pad_rows, s.pad_columns})});
  }
  void add(const nn::FullyConnected&) {
    if (!flat_) node("Flatten", {}, {int_attribute("axis", 1)});
    flat_ = true;
    node("Gemm", {"weight", "bias"}, {int_attribute("transB", 1)});
  }
  void add(const nn::Relu&) { node("Relu", {}); }
  void add(const nn::Pool& layer) {
    need_planes();
    const nn::PoolShape& s = layer.shape;
    if (layer.kind == nn::Pool::Kind::global_average) return node("GlobalAveragePool", {});
    node(layer.kind == nn::Pool::Kind::max ? "MaxPool" : "AveragePool", {},
         {ints_attribute("kernel_shape", {s.kernel_rows, s.kernel_columns}),
          ints_attribute("strides", {s.stride_rows, s.stride_columns})});
  }
  void add(const nn::BatchNorm& layer) {
    node("BatchNormalization", {"gamma", "beta", "running_mean", "running_variance"},
         {float_attribute("epsilon", nn::BatchNorm::epsilon)});
    if (layer.relu) node("Relu", {});
    if (layer.pool) add(*layer.pool);
  }
  /// Means, then standard deviations, as channels.
  void add(const nn::StatisticsPool&) {
    need_planes();
    const auto plane_mean = [&](const std::string& of) {
      add_node("ReduceMean", {of}, {ints_attribute("axes", {2, 3}), int_attribute("keepdims", 1)});
      return last_;
    };
    const std::string values = last_, mean = plane_mean(values);
    add_node("Sub", {values, mean}, {});
    add_node("Mul", {last_, last_}, {});
    plane_mean(last_);
    graph_.add(5, tensor(prefix_ + "epsilon", {}, std::vector<float>{static_cast<float>(nn::StatisticsPool::epsilon)},
                         type_float));
    node("Add", {"epsilon"});
    node("Sqrt", {});
    add_node("Concat", {mean, last_}, {int_attribute("axis", 1)});
  }

  void add(const nn::Branch&) {
    need_planes();
    kept_.push_back(last_);
  }
  void add(const nn::Join& layer) {
    need_planes();
    const std::vector<std::string> inputs{kept_.back(), last_};
    kept_.pop_back();
    layer.concatenates ? add_node("Concat", inputs, {int_attribute("axis", 1)}) : add_node("Add", inputs, {});
  }

  /// A layer of one file, by the words of its line.
  void add(const nn::Extension& layer) {
    const std::string text = layer.text();
    nn::Words words(text);
    const std::string word = words.take();
    if (word == "conv") return add_grouped(words);
    if (word == "maxpool" || word == "avgpool") return add_padded(word, words);
    if (word == "leakyrelu") return node("LeakyRelu", {}, {float_attribute("alpha", words.take_number(0, 1))});
    if (word == "tanh") return node("Tanh", {});
    if (word == "sigmoid") return node("Sigmoid", {});
    if (word == "dropout") return;  // passes on in inference
    if (word == "gelu") return add_gelu();
    if (word == "layernorm") return add_layernorm();
    throw Error(Code::not_supported, "layer '" + text + "'", "has no operator of ONNX",
                "export a network of decid's own layers");
  }
  static Message pair_attribute(std::string_view name, std::pair<int, int> pair) {
    return ints_attribute(name, {pair.first, pair.second});
  }
  static Message pads(std::pair<int, int> pair) {
    return ints_attribute("pads", {pair.first, pair.second, pair.first, pair.second});
  }
  /// The pair behind `name` of a line that text() wrote: all its options are there, in this order.
  static std::pair<int, int> option(nn::Words& words, const char* name) {
    words.take_if(name);
    return words.take_pair(0, 1 << 20);
  }
  void add_grouped(nn::Words& words) {
    need_planes();
    words.take();
    const std::pair<int, int> kernel = words.take_pair(1, 255), stride = option(words, "stride"),
                              pad = option(words, "pad"), groups = option(words, "groups"),
                              dilation = option(words, "dilation");
    node("Conv", {"weight", "bias"},
         {pair_attribute("kernel_shape", kernel), pair_attribute("strides", stride), pads(pad),
          int_attribute("group", groups.first), pair_attribute("dilations", dilation)});
  }
  void add_padded(const std::string& word, nn::Words& words) {
    need_planes();
    const std::pair<int, int> kernel = words.take_pair(1, 4096), stride = option(words, "stride"),
                              pad = option(words, "pad");
    const Message shape = pair_attribute("kernel_shape", kernel), strides = pair_attribute("strides", stride);
    if (word == "maxpool") return node("MaxPool", {}, {shape, strides, pads(pad)});
    node("AveragePool", {}, {shape, strides, pads(pad), int_attribute("count_include_pad", 1)});
  }
  /// A number as a tensor of the layer.
  void constant(const std::string& name, double value) {
    graph_.add(5, tensor(prefix_ + name, {}, std::vector<float>{static_cast<float>(value)}, type_float));
  }
  /// x (1 + erf(x / sqrt 2)) / 2
  void add_gelu() {
    const std::string x = last_;
    constant("root_half", 0.70710678118654752);
    constant("one", 1);
    constant("half", 0.5);
    node("Mul", {"root_half"});
    node("Erf", {});
    node("Add", {"one"});
    add_node("Mul", {x, last_}, {});
    node("Mul", {"half"});
  }
  /// Over channels, rows and columns; gamma and beta of channels.
  void add_layernorm() {
    need_planes();
    const auto mean = [&](const std::string& of) {
      add_node("ReduceMean", {of}, {ints_attribute("axes", {1, 2, 3}), int_attribute("keepdims", 1)});
      return last_;
    };
    const std::string x = last_;
    add_node("Sub", {x, mean(x)}, {});
    const std::string off = last_;
    add_node("Mul", {off, off}, {});
    mean(last_);
    constant("epsilon", 1e-5);
    node("Add", {"epsilon"});
    node("Sqrt", {});
    add_node("Div", {off, last_}, {});
    for (const char* name : {"gamma", "beta"}) {
      graph_.add(5, tensor(prefix_ + name + ".shape", {3}, std::vector<std::int64_t>{-1, 1, 1}, type_int64));
      const std::string value = last_;
      add_node("Reshape", {prefix_ + name, prefix_ + name + ".shape"}, {});
      add_node(std::string_view(name) == "gamma" ? "Mul" : "Add", {value, last_}, {});
    }
  }

  Message graph_;
  std::vector<std::string> kept_;  // what residuals and concats that are open began with
  std::string prefix_, last_ = "images";
  int nodes_ = 0;
  bool flat_ = false;
};

}  // namespace

namespace {

std::string bytes_of(const nn::Network<float>& network, const std::map<std::string, std::string>& metadata) {
  Message file;
  file.add(1, ir_version).add(2, std::string_view("decid")).add(3, std::string_view(version));
  file.add(7, Graph(network).message());
  file.add(8, Message().add(1, std::string_view()).add(2, operators_version));
  for (const auto& [key, value] : metadata)
    if (key != "log" && key != nn::content_hash_key)
      file.add(14, Message().add(1, std::string_view("decid." + key)).add(2, std::string_view(value)));
  return file.bytes();
}

}  // namespace

std::string onnx_bytes(const Model& model) {
  return bytes_of(model.network, nn::from_safetensors(to_bytes(model), "model").metadata);
}

std::string onnx_bytes(const nn::Network<float>& network) {
  return bytes_of(network, nn::to_tensors(network).metadata);
}

}  // namespace decid::tools
