/* What mimalloc uses of Apple's header of this name. */
#pragma once
#include <stddef.h>
#include <CommonCrypto/CommonCryptoError.h>
CCRNGStatus CCRandomGenerateBytes(void *bytes, size_t count);
