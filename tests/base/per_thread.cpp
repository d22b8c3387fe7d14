#include "base/per_thread.hpp"

#include <doctest/doctest.h>
#include <pthread.h>

#include <atomic>
#include <thread>
#include <vector>

using namespace decid;

namespace {

std::atomic<int> alive{0};

struct Counted {
  Counted() { ++alive; }
  ~Counted() { --alive; }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;
  int value = 0;
};

struct Other {
  int value = 0;
};

}  // namespace

TEST_CASE("per_thread: one object per thread, destroyed with the thread") {
  per_thread<Counted>().value = 1;
  CHECK(alive == 1);
  std::thread([] {
    CHECK(per_thread<Counted>().value == 0);
    per_thread<Counted>().value = 2;
    CHECK(per_thread<Counted>().value == 2);
    CHECK(alive == 2);
  }).join();
  CHECK(alive == 1);
  CHECK(per_thread<Counted>().value == 1);
}

TEST_CASE("per_thread: types have objects of their own") {
  per_thread<Counted>().value = 1;
  per_thread<Other>().value = 3;
  CHECK(per_thread<Counted>().value == 1);
  CHECK(per_thread<Other>().value == 3);
}

TEST_CASE("per_thread: more threads than a process has keys") {
  const int before = alive;
  for (int batch = 0; batch < 70; ++batch) {
    std::vector<std::thread> threads;
    for (int i = 0; i < 20; ++i) threads.emplace_back([] { per_thread<Counted>().value = 4; });
    for (std::thread& thread : threads) thread.join();
  }
  CHECK(alive == before);
}

TEST_CASE(
    "per_thread: what a thread destroys after its object may ask for it again, and gets a fresh one, which goes too") {
  const int before = alive;
  static int seen = 0;
  std::thread([] {
    per_thread<Counted>().value = 8;
    // Keys are destroyed in the order in which they were made: this one after per_thread's.
    static pthread_key_t key;
    REQUIRE(pthread_key_create(&key, [](void*) { seen = 1 + per_thread<Counted>().value; }) == 0);
    REQUIRE(pthread_setspecific(key, &key) == 0);
  }).join();
  CHECK(seen == 1);
  CHECK(alive == before);
}
