/* What mimalloc uses of Apple's header of this name. */
#pragma once
#include <stdint.h>
typedef int32_t CCCryptorStatus;
typedef CCCryptorStatus CCRNGStatus;
enum { kCCSuccess = 0 };
