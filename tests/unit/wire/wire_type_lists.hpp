#pragma once

#include <gtest/gtest.h>

#include <tuple>

#include "wire_types.hpp"

namespace driveline::wire::test {

/// Every type with encode() and decode(). wire_type_list_test compares with the headers.
using Structures =
    std::tuple<EthernetHeader, EtherCatHeader, DatagramHeader, SyncManagerChannel, FmmuEntity, MailboxHeader,
               MailboxErrorReply, CoeHeader, SdoHeader, Emergency, SdoInfoHeader, FoeHeader, EoeHeader, EoeIpParameters,
               EoeAddressFilter, SoeHeader, SoeListHeader, SoeAttribute>;

/// Every type with raw() and from_raw().
using RegisterTypes = std::tuple<AlControl, AlStatus, DlStatus, SyncManagerControl, SdoSegmentHeader>;

/// The tuple's types as GoogleTest wants them.
template <typename Tuple>
struct AsTestTypes;
template <typename... T>
struct AsTestTypes<std::tuple<T...>> {
  using Type = ::testing::Types<T...>;
};

}  // namespace driveline::wire::test
