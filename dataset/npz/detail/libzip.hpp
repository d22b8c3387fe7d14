// libzip, loaded with the first data set that is read. It loads libcrypto, whose 17,000 relocations would slow down
// every other start.
#pragma once

#include <zip.h>

#include "base/files/shared_library.hpp"

namespace decid::dataset {

/// The functions of libzip used here. DECID_LIBZIP_SONAME: the name of the library that belongs to its header, with the
/// major version.
class Libzip {
  SharedLibrary library_{DECID_LIBZIP_SONAME, "data sets", "need libzip", "install it (Debian: libzip4)"};

 public:
  decltype(&zip_open) open = library_.find<decltype(&zip_open)>("zip_open");
  decltype(&zip_discard) discard = library_.find<decltype(&zip_discard)>("zip_discard");
  decltype(&zip_stat_init) stat_init = library_.find<decltype(&zip_stat_init)>("zip_stat_init");
  decltype(&zip_stat) stat = library_.find<decltype(&zip_stat)>("zip_stat");
  decltype(&zip_strerror) error_text = library_.find<decltype(&zip_strerror)>("zip_strerror");
  decltype(&zip_get_error) error_of = library_.find<decltype(&zip_get_error)>("zip_get_error");
  decltype(&zip_fopen) open_member = library_.find<decltype(&zip_fopen)>("zip_fopen");
  decltype(&zip_fclose) close_member = library_.find<decltype(&zip_fclose)>("zip_fclose");
  decltype(&zip_fread) read = library_.find<decltype(&zip_fread)>("zip_fread");
  decltype(&zip_file_get_error) error_of_member = library_.find<decltype(&zip_file_get_error)>("zip_file_get_error");
  decltype(&zip_file_strerror) member_error_text = library_.find<decltype(&zip_file_strerror)>("zip_file_strerror");
  decltype(&zip_error_init_with_code) error_init =
      library_.find<decltype(&zip_error_init_with_code)>("zip_error_init_with_code");
  decltype(&zip_error_strerror) to_text = library_.find<decltype(&zip_error_strerror)>("zip_error_strerror");
  decltype(&zip_error_code_zip) code_of = library_.find<decltype(&zip_error_code_zip)>("zip_error_code_zip");
  decltype(&zip_error_fini) error_fini = library_.find<decltype(&zip_error_fini)>("zip_error_fini");
};

/// Returns the functions, loaded once. Throws Error at each call if loading fails.
inline const Libzip& libzip() {
  static const Libzip loaded;
  return loaded;
}

}  // namespace decid::dataset
