// As stdlib.h here.
#pragma once

#include_next <dirent.h>

#define DT_SOCK 12
