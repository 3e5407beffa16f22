/** librt: an embeddable ray tracing library. This header includes all of the public API. */
#ifndef LIBRT_RT_H
#define LIBRT_RT_H

#include "librt/base.h"
#include "librt/draw.h"
#include "librt/explain.h"
#include "librt/image.h"
#include "librt/import.h"
#include "librt/render.h"
#include "librt/scene.h"
#include "librt/trace.h"
#include "librt/tree.h"

#endif
