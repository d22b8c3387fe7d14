// Tensors of a batch of images, laid out for equal bits and speed: 16 samples are adjacent in the innermost dimension,
// [block of 16 samples][channel][row][column][lane]. A lane never mixes with another except in reductions over the
// batch, so every output is one chain of fused multiply-adds for any vector width.
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <span>
#include <type_traits>

namespace decid::nn {

/// Adjacent samples: one AVX-512 register, two of AVX2, four of SSE or NEON.
inline constexpr int lanes = 16;

/// The shape of one sample.
struct Shape {
  int channels = 0, rows = 0, columns = 0;
  int size() const { return channels * rows * columns; }
  bool operator==(const Shape&) const = default;
};

/// Rows and columns of zeros on each side of a plane.
struct Halo {
  int rows = 0, columns = 0;
  bool empty() const { return rows == 0 && columns == 0; }
};
/// Returns the smallest halo that covers both.
inline Halo larger(Halo a, Halo b) {
  return {a.rows > b.rows ? a.rows : b.rows, a.columns > b.columns ? a.columns : b.columns};
}

// Plain data, because kernels compiled for different instruction sets share them; the conversions are inlined so that
// no copy compiled for one set can be linked into code for another.

/// One channel's plane of a block of 16 samples; columns are `lanes` values apart.
template <class T>
struct Plane {
  T* data;             ///< row 0, column 0
  std::ptrdiff_t row;  ///< stride of rows in values
  int rows, columns;

  [[gnu::always_inline]] operator Plane<const T>() const requires(!std::is_const_v<T>) {
    return {data, row, rows, columns};
  }
};

/// The planes of a block of 16 samples; strides in values.
template <class T>
struct BlockView {
  T* data;  ///< row 0, column 0 of channel 0
  std::ptrdiff_t channel, row;

  [[gnu::always_inline]] operator BlockView<const T>() const requires(!std::is_const_v<T>) {
    return {data, channel, row};
  }
};

/// Throws Error: sample `sample` of a batch of `batch`, or a span of `values` values where a sample has `size`. Not
/// inlined, because the text functions that it calls must not be compiled for an instruction set.
[[noreturn]] void refuse_sample(int sample, int batch, std::size_t values, int size);

/// Asks the system for large pages for `bytes` bytes at `memory`. This is a hint, which affects only the speed.
void advise_large_pages(void* memory, std::size_t bytes);

/// Memory aligned to a cache line, zeroed; large buffers lie on large pages where the system has them, because a layer
/// reads hundreds of planes at once, and with pages of 4 KB waits for the page table. Grows, never shrinks.
template <class T>
class AlignedBuffer {
 public:
  void reserve(std::size_t count) {
    if (count <= count_) return;
    const std::size_t bytes = count * sizeof(T);
    const std::align_val_t alignment{bytes >= large ? large_page : cache_line};
    data_ = {static_cast<T*>(::operator new(bytes, alignment)), Free{alignment}};
    if (bytes >= large) advise_large_pages(data_.get(), bytes);
    for (std::size_t i = 0; i < count; ++i) data_[i] = T(0);
    count_ = count;
  }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  std::size_t size() const { return count_; }

 private:
  static constexpr std::size_t cache_line = 64, large_page = 2U << 20U, large = 2 * large_page;
  struct Free {
    std::align_val_t alignment{cache_line};
    void operator()(T* p) const { ::operator delete(p, alignment); }
  };
  std::unique_ptr<T[], Free> data_;
  std::size_t count_ = 0;
};

/// A batch of samples in memory that it does not own (an AlignedBuffer). As with std::span, `T` determines the access:
/// TensorView<const T> reads, TensorView<T> reads and writes and converts to it. Around each plane lies a halo of
/// zeros, so that a convolution reads its padding like any other value.
template <class T>
class TensorView {
 public:
  using Value = std::remove_const_t<T>;

  TensorView() = default;
  /// `memory` holds at least required(shape, batch, halo) values.
  TensorView(T* memory, Shape shape, int batch, Halo halo)
      : memory_(memory), shape_(shape), batch_(batch), halo_(halo) {}
  operator TensorView<const T>() const requires(!std::is_const_v<T>) { return {memory_, shape_, batch_, halo_}; }

  static std::size_t required(Shape shape, int batch, Halo halo) {
    const auto plane = static_cast<std::size_t>(shape.rows + 2 * halo.rows) *
                       static_cast<std::size_t>(shape.columns + 2 * halo.columns);
    return count_blocks(batch) * static_cast<std::size_t>(shape.channels) * plane * lanes;
  }
  static std::size_t count_blocks(int batch) { return static_cast<std::size_t>((batch + lanes - 1) / lanes); }

  const Shape& shape() const { return shape_; }
  int batch() const { return batch_; }
  Halo halo() const { return halo_; }
  int blocks() const { return static_cast<int>(count_blocks(batch_)); }
  /// Lanes of a block that hold samples; the others hold values that no reduction reads.
  int valid_lanes(int block) const { return batch_ - block * lanes < lanes ? batch_ - block * lanes : lanes; }
  /// Sets a smaller number of samples in the same memory.
  void set_batch(int batch) { batch_ = batch; }

  BlockView<T> block(int block) const {
    return {memory_ + block * channel_stride() * shape_.channels + halo_.rows * row_stride() + halo_.columns * lanes,
            channel_stride(), row_stride()};
  }
  Plane<T> plane(int block, int channel) const {
    return {row(block, channel, 0), row_stride(), shape_.rows, shape_.columns};
  }
  T* row(int block, int channel, int row) const {
    const BlockView<T> v = this->block(block);
    return v.data + channel * v.channel + row * v.row;
  }
  T& at(int sample, int channel, int row_index, int column) const {
    return row(sample / lanes, channel, row_index)[column * lanes + sample % lanes];
  }

  /// values: shape().size() of one sample, channel-major. Both throw Error for a span of another size and for a sample
  /// that is not in the batch.
  void load(int sample, std::span<const Value> values) const requires(!std::is_const_v<T>) {
    check_sample(sample, values.size());
    std::size_t i = 0;
    for_each_value(sample, [&](T& value) { value = values[i++]; });
  }
  void store(int sample, std::span<Value> values) const {
    check_sample(sample, values.size());
    std::size_t i = 0;
    for_each_value(sample, [&](const T& value) { values[i++] = value; });
  }
  /// Zeroes the halo, needed when the memory served another tensor before.
  void clear_halo() const requires(!std::is_const_v<T>) {
    if (halo_.empty()) return;
    const std::ptrdiff_t side = static_cast<std::ptrdiff_t>(halo_.columns) * lanes;
    const std::ptrdiff_t width = static_cast<std::ptrdiff_t>(shape_.columns) * lanes;
    for (int b = 0; b < blocks(); ++b)
      for (int c = 0; c < shape_.channels; ++c)
        for (int r = -halo_.rows; r < shape_.rows + halo_.rows; ++r) {
          T* begin = row(b, c, r) - side;
          const bool inside = r >= 0 && r < shape_.rows;
          for (std::ptrdiff_t i = 0; i < (inside ? side : row_stride()); ++i) begin[i] = T(0);
          if (inside)
            for (std::ptrdiff_t i = 0; i < side; ++i) begin[side + width + i] = T(0);
        }
  }

 private:
  std::ptrdiff_t row_stride() const { return static_cast<std::ptrdiff_t>(shape_.columns + 2 * halo_.columns) * lanes; }
  std::ptrdiff_t channel_stride() const { return row_stride() * (shape_.rows + 2 * halo_.rows); }
  void check_sample(int sample, std::size_t values) const {
    if (sample < 0 || sample >= batch_ || values != static_cast<std::size_t>(shape_.size()))
      refuse_sample(sample, batch_, values, shape_.size());
  }
  template <class Body>
  void for_each_value(int sample, const Body& body) const {
    for (int c = 0; c < shape_.channels; ++c)
      for (int r = 0; r < shape_.rows; ++r) {
        T* const values = row(sample / lanes, c, r) + sample % lanes;
        for (int j = 0; j < shape_.columns; ++j) body(values[j * lanes]);
      }
  }

  T* memory_ = nullptr;
  Shape shape_;
  int batch_ = 0;
  Halo halo_;
};

}  // namespace decid::nn
