#include "web_server.hpp"

#include <microhttpd.h>

#include <string>
#include <string_view>

namespace driveline::endpoint {
namespace {

constexpr std::uint16_t kPort = 80;
constexpr unsigned kMaxConnections = 32;
constexpr unsigned kConnectionTimeoutSeconds = 15;

MHD_Result answer(MHD_Connection* connection, unsigned status, std::string_view content, const char* type) {
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast): the library copies the bytes and does not write them
  auto* bytes = const_cast<char*>(content.data());
  auto* response = MHD_create_response_from_buffer(content.size(), bytes, MHD_RESPMEM_MUST_COPY);
  if (response == nullptr) return MHD_NO;
  MHD_add_response_header(response, MHD_HTTP_HEADER_CONTENT_TYPE, type);
  MHD_add_response_header(response, MHD_HTTP_HEADER_CACHE_CONTROL, "no-store");
  const auto queued = MHD_queue_response(connection, status, response);
  MHD_destroy_response(response);
  return queued;
}

MHD_Result handle(void* state, MHD_Connection* connection, const char* url, const char* method, const char* /*version*/,
                  const char* /*upload*/, std::size_t* upload_size, void** seen) {
  // The library calls a first time before the rest of the request has arrived.
  if (*seen == nullptr) {
    *seen = connection;
    return MHD_YES;
  }
  if (*upload_size != 0) {
    *upload_size = 0;
    return MHD_YES;
  }
  const std::string_view verb = method;
  if (verb != MHD_HTTP_METHOD_GET && verb != MHD_HTTP_METHOD_HEAD) {
    return answer(connection, MHD_HTTP_METHOD_NOT_ALLOWED, "only GET and HEAD\n", "text/plain");
  }
  const std::string_view path = url;
  if (path == "/") return answer(connection, MHD_HTTP_OK, cockpit_page(), "text/html; charset=utf-8");
  if (path == "/state.json") {
    return answer(connection, MHD_HTTP_OK, state_json(*static_cast<const CockpitState*>(state)), "application/json");
  }
  return answer(connection, MHD_HTTP_NOT_FOUND, "this server has / and /state.json\n", "text/plain");
}

}  // namespace

void WebServer::Stop::operator()(MHD_Daemon* daemon) const noexcept {
  MHD_stop_daemon(daemon);
}

Outcome<WebServer> WebServer::open(const CockpitState& state) {
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast): the library returns the pointer and never writes there
  auto* context = const_cast<CockpitState*>(&state);
  auto* daemon =
      MHD_start_daemon(MHD_USE_EPOLL, kPort, nullptr, nullptr, &handle, context, MHD_OPTION_CONNECTION_LIMIT,
                       kMaxConnections, MHD_OPTION_CONNECTION_TIMEOUT, kConnectionTimeoutSeconds, MHD_OPTION_END);
  if (daemon == nullptr) return failed("HTTP port 80 cannot be opened");
  return WebServer(daemon);
}

void WebServer::wait_for(std::vector<pollfd>& descriptors) const {
  const auto* info = MHD_get_daemon_info(daemon_.get(), MHD_DAEMON_INFO_EPOLL_FD);
  if (info != nullptr) descriptors.push_back({info->epoll_fd, POLLIN, 0});
}

void WebServer::serve() {
  static_cast<void>(MHD_run(daemon_.get()));
}

}  // namespace driveline::endpoint
