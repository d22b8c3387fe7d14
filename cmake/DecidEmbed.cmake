# Files inside the program, so that it needs nothing beside itself at run time.

# decid_embed(target symbol file): `std::string_view decid::embedded::<symbol>()`, declared in "embedded/<symbol>.hpp",
# is the content of `file`. The assembler reads the file (.incbin), which takes megabytes in no time; an edit of the
# file rebuilds. Must be called in the directory that made the target: a source's dependencies are known only there.
function(decid_embed target symbol file)
  get_filename_component(path ${file} ABSOLUTE)
  if(NOT EXISTS ${path})
    message(FATAL_ERROR "decid_embed: ${path} does not exist")
  endif()
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/embedded)
  file(CONFIGURE OUTPUT ${folder}/${symbol}.hpp @ONLY CONTENT [[
// Generated: the content of @path@.
#pragma once

#include <string_view>

namespace decid::embedded {
std::string_view @symbol@();
}
]])
  # 64-byte alignment: the content may be read as numbers where it lies.
  file(CONFIGURE OUTPUT ${folder}/${symbol}.cpp @ONLY CONTENT [[
// Generated: the content of @path@.
#include "embedded/@symbol@.hpp"

#if defined(__wasm__)

// clang 19 embeds as C23 does; its assembler for WebAssembly has no such sections.
alignas(64) static const char content[] = {
#embed "@path@"
    , 0};

namespace decid::embedded {

std::string_view @symbol@() {
  return {content, sizeof content - 1};
}

}  // namespace decid::embedded

#else

asm(R"(
.pushsection .rodata
.balign 64
.global decid_embedded_@symbol@_begin
.hidden decid_embedded_@symbol@_begin
decid_embedded_@symbol@_begin:
.incbin "@path@"
.global decid_embedded_@symbol@_end
.hidden decid_embedded_@symbol@_end
decid_embedded_@symbol@_end:
.byte 0
.popsection
)");

extern "C" {
extern const char decid_embedded_@symbol@_begin[];
extern const char decid_embedded_@symbol@_end[];
}

namespace decid::embedded {

std::string_view @symbol@() {
  return {decid_embedded_@symbol@_begin,
          static_cast<std::size_t>(decid_embedded_@symbol@_end - decid_embedded_@symbol@_begin)};
}

}  // namespace decid::embedded

#endif
]])
  # In one object with others it would lose that dependency, and keep the old content.
  set_source_files_properties(${folder}/${symbol}.cpp PROPERTIES OBJECT_DEPENDS ${path} SKIP_UNITY_BUILD_INCLUSION ON
    COMPILE_OPTIONS "$<$<STREQUAL:${CMAKE_SYSTEM_PROCESSOR},wasm32>:-Wno-c23-extensions>")
  target_sources(${target} PRIVATE ${folder}/${symbol}.cpp)
  target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_BINARY_DIR})
endfunction()
