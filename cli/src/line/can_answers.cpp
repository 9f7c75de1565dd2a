#include "line/can_answers.hpp"

#include <nlohmann/json.hpp>

#include "axes/axis_view.hpp"
#include "groups/group_view.hpp"
#include "text/json_text.hpp"
#include "text/node_diagnosis.hpp"

namespace driveline::cli {

std::string answer_about_can(runtime::Line& line, std::string_view question) {
  if (question.starts_with("eoe")) return "error: CANopen has no Ethernet over the bus";
  if (!question.starts_with("diag")) {
    return "error: the page of a drive is that of EtherCAT; `driveline axis NAME status` shows an axis on a CAN bus, "
           "and "
           "`driveline upload` the objects of its drive";
  }
  auto* master = line.can_master();
  if (master == nullptr) return "error: the line is not in operation";
  if (question != "diag json") return nodes_text(*master) + owners_text(line.axes()) + groups_text(line.groups());
  auto document = nodes_json(*master);
  document["axes"] = owners_json(line.axes());
  if (!line.groups().groups().empty()) document["axis_groups"] = groups_json(line.groups());
  return json_text(document);
}

}  // namespace driveline::cli
