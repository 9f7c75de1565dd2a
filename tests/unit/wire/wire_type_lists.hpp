#pragma once

#include <gtest/gtest.h>

#include <tuple>

#include "wire_types.hpp"

namespace driveline::wire::test {

/// All types with encode() and decode(). wire_type_list_test compares this list with the headers.
using Structures =
    std::tuple<EthernetHeader, EtherCatHeader, DatagramHeader, SyncManagerChannel, FmmuEntity, MailboxHeader,
               MailboxErrorReply, CoeHeader, SdoHeader, Emergency, SdoInfoHeader, FoeHeader, EoeHeader, EoeIpParameters,
               EoeAddressFilter, SoeHeader, SoeListHeader, SoeAttribute>;

/// All types with raw() and from_raw().
using RegisterTypes = std::tuple<AlControl, AlStatus, DlStatus, SyncManagerControl, SdoSegmentHeader>;

/// The types of the tuple in the form for GoogleTest.
template <typename Tuple>
struct AsTestTypes;
template <typename... T>
struct AsTestTypes<std::tuple<T...>> {
  using Type = ::testing::Types<T...>;
};

}  // namespace driveline::wire::test
