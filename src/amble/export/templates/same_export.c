
#include "amble_controller.h"
#if AMBLE_CONTENT != @CONTENT@
#error "this file and amble_controller.h belong to two exports; export the controller again"
#endif
