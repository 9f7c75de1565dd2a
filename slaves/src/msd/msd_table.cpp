#include "driveline/slaves/msd/msd_table.hpp"

#include "driveline/slaves/msd/core/drive_table.hpp"
#include "driveline/slaves/msd/ethercat_values.hpp"

namespace driveline::slaves::msd {
namespace {

template <Variant kVariant>
const DictionaryTable& table_of() {
  static const DictionaryTable kTable({drive_rows(kVariant), ethercat_rows()}, kBusValue.end());
  return kTable;
}

}  // namespace

const DictionaryTable& dictionary_table(Variant variant) {
  switch (variant) {
    case Variant::kServoOne:
      return table_of<Variant::kServoOne>();
    case Variant::kServoOneJunior:
      return table_of<Variant::kServoOneJunior>();
    case Variant::kMsd:
      break;
  }
  return table_of<Variant::kMsd>();
}

}  // namespace driveline::slaves::msd
