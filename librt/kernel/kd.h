/* What kd-tree walks share. */
#ifndef RTK_KD_H
#define RTK_KD_H

#include "snapshot.h"

#define RTK_KD_STACK 96u /* a level leaves at most one node waiting; trees are no deeper (checked where they come in) */

#endif
