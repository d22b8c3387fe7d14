// Tests of base/isa.hpp.
#include "base/isa.hpp"

#include <doctest/doctest.h>

#include <algorithm>

#include "base/error.hpp"

using namespace decid;

TEST_CASE("instruction sets: names, and allowed requests") {
  const std::vector<Isa> available = available_isas();
  REQUIRE(!available.empty());
  CHECK(available.front() == Isa::reference);
  CHECK(std::find(available.begin(), available.end(), chosen_isa()) != available.end());
  for (const Isa isa : available) CHECK(isa_from_name("test", name(isa)) == isa);
  CHECK((!halves_512_bits() || available.back() == Isa::avx512));
  const bool arm = available.back() == Isa::neon;
  for (const std::string wanted : {"sse9", "", "AVX2", arm ? "avx2" : "neon"}) {
    INFO(wanted);
    CHECK_THROWS_AS(isa_from_name("test", wanted), Error);
  }
  try {
    isa_from_name("DECID_ISA", "sse9");
    FAIL("no error");
  } catch (const Error& e) {
    CHECK(e.where() == "DECID_ISA");
    CHECK(e.problem().find("sse9") != std::string::npos);
    for (const Isa isa : available) CHECK(e.remedy().find(name(isa)) != std::string::npos);
  }
}
