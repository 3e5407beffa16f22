/* The lanes of one instruction set. */
#include "lanes_table.h"

const rti_lanes RTI_ISA_FN(rti_lanes) = {
    RTI_ISA_FN(rti_lanes_camera), RTI_ISA_FN(rti_lanes_sheaves), RTI_ISA_FN(rti_lanes_whitted), RTI_ISA_FN(rti_lanes_path),
    RTI_ISA_FN(rti_lanes_ao),     RTI_ISA_FN(rti_lanes_shine),   RTI_ISA_FN(rti_lanes_one),     RTI_ISA_FN(rti_lanes_around),
    RTI_ISA_FN(rti_lanes_arrive), RTI_ISA_FN(rti_lanes_resolve),
};
