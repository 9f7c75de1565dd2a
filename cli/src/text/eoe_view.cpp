#include "text/eoe_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace driveline::cli {
namespace {

/// The name of a slave up to its first zero byte.
std::string name_text(const wire::EoeIpParameters::Name& name) {
  return {name.begin(), std::find(name.begin(), name.end(), '\0')};
}

std::string text_or_dash(const std::optional<wire::IpV4Address>& address) {
  return address ? runtime::to_text(*address) : "-";
}

nlohmann::json text_or_null(const std::optional<wire::IpV4Address>& address) {
  if (!address) return nullptr;
  return runtime::to_text(*address);
}

/// Dropped frames of a port, in both directions.
std::uint64_t dropped(const runtime::EoePortReport& port) {
  const auto& figures = port.figures;
  auto count = figures.full + figures.flood_limit + figures.refused;
  if (port.fragments) count += port.fragments->given_up + port.fragments->lost;
  return count;
}

}  // namespace

std::string to_text(const runtime::EoeReport& report) {
  std::size_t widest = 6;
  for (const auto& port : report.ports) widest = std::max(widest, port.figures.name.size());
  auto text = fmt::format("{:<{}}  {:<6}{:<17}{:>10}{:>10}{:>12}{:>12}{:>9}\n", "port", widest, "link", "address",
                          "frames in", "out", "bytes in", "out", "dropped");
  for (const auto& port : report.ports) {
    const auto& figures = port.figures;
    text += fmt::format("{:<{}}  {:<6}{:<17}{:>10}{:>10}{:>12}{:>12}{:>9}\n", figures.name, widest,
                        figures.link ? "up" : "down", runtime::to_text(port.ip), figures.received, figures.sent,
                        figures.bytes_in, figures.bytes_out, dropped(port));
    for (const auto& mac : figures.addresses) text += fmt::format("{:<{}}{}\n", "", widest + 8, runtime::mac_text(mac));
  }
  return text;
}

nlohmann::json to_json(const runtime::EoeReport& report) {
  auto ports = nlohmann::json::array();
  for (const auto& port : report.ports) {
    const auto& figures = port.figures;
    auto addresses = nlohmann::json::array();
    for (const auto& mac : figures.addresses) addresses.push_back(runtime::mac_text(mac));
    nlohmann::json row = {{"name", figures.name},
                          {"link", figures.link},
                          {"ip", runtime::to_text(port.ip)},
                          {"addresses", std::move(addresses)},
                          {"frames_in", figures.received},
                          {"frames_out", figures.sent},
                          {"bytes_in", figures.bytes_in},
                          {"bytes_out", figures.bytes_out},
                          {"dropped_full", figures.full},
                          {"dropped_flood", figures.flood_limit},
                          {"refused", figures.refused}};
    if (port.slave) row["slave"] = *port.slave;
    if (const auto& eoe = port.fragments) {
      row["fragments"] = {{"in", eoe->fragments_in}, {"out", eoe->fragments_out},   {"given_up", eoe->given_up},
                          {"lost", eoe->lost},       {"malformed", eoe->malformed}, {"stray", eoe->stray}};
    }
    ports.push_back(std::move(row));
  }
  return {{"network", runtime::to_text(report.network)}, {"ports", std::move(ports)}};
}

std::string to_text(std::span<const EoeAddressView> slaves) {
  auto text = fmt::format("{:<4}{:<17}{:<17}{:<17}{:<19}{:<16}{}\n", "", "address", "mask", "gateway", "MAC",
                          "DNS name", "slave");
  for (const auto& slave : slaves) {
    const auto& has = slave.parameters;
    const auto mac = has.mac ? runtime::mac_text(*has.mac) : "-";
    const auto name = has.dns_name ? name_text(*has.dns_name) : "-";
    text += fmt::format("{:<4}{:<17}{:<17}{:<17}{:<19}{:<16}{}{}\n", slave.position, text_or_dash(has.ip),
                        text_or_dash(has.subnet_mask), text_or_dash(has.gateway), mac, name, slave.name,
                        !slave.eoe              ? ", which has no EoE"
                        : slave.trouble.empty() ? ""
                                                : ": " + slave.trouble);
  }
  return text;
}

nlohmann::json to_json(std::span<const EoeAddressView> slaves) {
  auto rows = nlohmann::json::array();
  for (const auto& slave : slaves) {
    nlohmann::json row = {{"position", slave.position}, {"name", slave.name}, {"eoe", slave.eoe}};
    if (!slave.trouble.empty()) row["trouble"] = slave.trouble;
    if (slave.eoe && slave.trouble.empty()) {
      const auto& has = slave.parameters;
      row["ip"] = text_or_null(has.ip);
      row["subnet_mask"] = text_or_null(has.subnet_mask);
      row["gateway"] = text_or_null(has.gateway);
      row["dns_server"] = text_or_null(has.dns_server);
      row["mac"] = has.mac ? nlohmann::json(runtime::mac_text(*has.mac)) : nlohmann::json(nullptr);
      row["dns_name"] = has.dns_name ? nlohmann::json(name_text(*has.dns_name)) : nlohmann::json(nullptr);
    }
    rows.push_back(std::move(row));
  }
  return {{"slaves", std::move(rows)}};
}

std::string to_text(std::span<const runtime::GatewayClient> clients) {
  std::string text;
  for (const auto& client : clients) {
    text += fmt::format("{:<28}{:>8} requests{:>8} answers{:>8} refused{:>8} malformed\n", client.name, client.requests,
                        client.answers, client.refused, client.malformed);
  }
  return text;
}

nlohmann::json to_json(std::span<const runtime::GatewayClient> clients) {
  auto rows = nlohmann::json::array();
  for (const auto& client : clients) {
    rows.push_back({{"name", client.name},
                    {"requests", client.requests},
                    {"answers", client.answers},
                    {"refused", client.refused},
                    {"malformed", client.malformed}});
  }
  return rows;
}

}  // namespace driveline::cli
