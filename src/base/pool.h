/* base/pool.h: the threads behind parallel_for. */
#ifndef BASE_POOL_H
#define BASE_POOL_H

#include "base/base.h"

void pool_destroy(pnb_context *context);

#endif
