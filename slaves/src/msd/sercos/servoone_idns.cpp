#include "driveline/slaves/msd/sercos/servoone_idns.hpp"

#include "idn_table_row.hpp"

namespace driveline::slaves::msd::sercos {

const IdnTable& servoone_idns() {
  static const IdnTable kTable({standard_idns(), product_idns()}, kServoOneValue.end());
  return kTable;
}

}  // namespace driveline::slaves::msd::sercos
