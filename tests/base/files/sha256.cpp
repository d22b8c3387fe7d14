// Tests of base/files/sha256.hpp: the examples that NIST publishes with FIPS 180-4, whole and in pieces.
#include "base/files/sha256.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "base/files/detail/sha256_blocks.hpp"

using decid::sha256;

TEST_CASE("sha256: NIST examples") {
  CHECK(sha256("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq") ==
        "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  CHECK(sha256("abcdefghbcdefghicdefghijdefghijkefghijklfghijklmghijklmnhijklmnoijklmnopjklmnopqklmnopqrlmnopqrs"
               "mnopqrstnopqrstu") == "cf5b16a778af8380036ce59e7b0492370b249b11e8f07a51afac45037afee9d1");
  CHECK(sha256(std::string(1'000'000, 'a')) == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST_CASE("sha256: pieces of any length hash as the whole") {
  std::string content;
  for (int i = 0; i < 300; ++i) content += static_cast<char>(i * 37 % 251);
  // Every length around one and two blocks, so that the padding takes each of its forms.
  for (std::size_t length = 0; length <= content.size(); ++length) {
    const std::string whole = content.substr(0, length);
    const std::string expected = sha256(whole);
    for (const std::size_t piece : {1u, 7u, 63u, 64u, 65u, 128u}) {
      decid::Sha256 hash;
      for (std::size_t i = 0; i < length; i += piece) hash.update(whole.data() + i, std::min(piece, length - i));
      REQUIRE(hash.hex() == expected);
    }
  }
  CHECK(sha256(content.substr(0, 55)) != sha256(content.substr(0, 56)));
}

TEST_CASE("sha256: the processor's instructions compress as the definition does") {
  const decid::Sha256Blocks fast = decid::sha256_blocks_x86();
  if (fast == nullptr) {
    MESSAGE("this processor has no SHA extensions");
    return;
  }
  std::vector<std::uint8_t> content(64 * 40);
  std::uint32_t word = 1;
  for (std::uint8_t& byte : content) byte = static_cast<std::uint8_t>((word = word * 1664525 + 1013904223) >> 24);
  for (std::size_t count = 0; count <= 40; ++count) {
    decid::Sha256State plain{1, 2, 3, 4, 5, 6, 7, 0xffffffff}, by_processor = plain;
    decid::sha256_blocks_plain(plain, content.data(), count);
    fast(by_processor, content.data(), count);
    REQUIRE(by_processor == plain);
  }
}
