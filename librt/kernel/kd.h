/* What kd-tree walks share. */
#ifndef RTK_KD_H
#define RTK_KD_H

#include "snapshot.h"

#define RTK_KD_DEPTH 96u          /* trees are no deeper (checked where they come in) */
#define RTK_KD_STACK RTK_KD_DEPTH /* a level leaves at most one node waiting */

#endif
