#include "stream/stream_peer.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>

namespace driveline::runtime {
namespace {

/// Whether the peer has the group among its supplementary groups.
bool in_group(int socket, gid_t group) {
  std::array<gid_t, 256> groups{};
  socklen_t size = sizeof groups;
  // A peer with more groups causes an error, and counts as not being in the group.
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERGROUPS, groups.data(), &size) != 0) return false;
  const auto end = groups.begin() + size / sizeof(gid_t);
  return std::find(groups.begin(), end, group) != end;
}

}  // namespace

std::optional<StreamPeer> peer_of(int socket) {
  ucred credentials{};
  socklen_t size = sizeof credentials;
  if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0) return std::nullopt;
  return StreamPeer{{}, credentials.pid, credentials.uid, credentials.gid};
}

bool may_stream(int socket, const StreamPeer& peer, const StreamUsers& allowed) {
  if (peer.user == 0 || peer.user == ::geteuid()) return true;
  if (std::find(allowed.users.begin(), allowed.users.end(), peer.user) != allowed.users.end()) return true;
  return allowed.group && (peer.group == *allowed.group || in_group(socket, *allowed.group));
}

}  // namespace driveline::runtime
