#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "wire_type_lists.hpp"

/// A wire type in the headers that is missing in the lists has no golden bytes: this test names it.
namespace driveline::wire::test {
namespace {

template <template <typename> typename SampleOf, typename... T>
std::set<std::string> names(const std::tuple<T...>*) {
  return {std::string(SampleOf<T>::kName)...};
}

/// Names of the structs in the headers whose body declares a function with the name `function`.
std::set<std::string> structs_with(const std::string& function) {
  std::set<std::string> found;
  for (const auto& entry : std::filesystem::directory_iterator(DRIVELINE_WIRE_HEADERS)) {
    std::ifstream file(entry.path());
    std::string structure;
    for (std::string line; std::getline(file, line);) {
      if (line.starts_with("struct ")) structure = line.substr(7, line.find(' ', 7) - 7);
      if (line.starts_with("}")) structure.clear();  // members are indented, so this ends the struct
      if (!structure.empty() && line.find(" " + function + "(") != std::string::npos) found.insert(structure);
    }
  }
  return found;
}

TEST(WireTypeList, HasEveryStructureOfTheHeaders) {
  const auto declared = structs_with("decode");
  EXPECT_THAT(declared, ::testing::Contains("EthernetHeader"));  // the search finds something
  EXPECT_EQ(names<Sample>(static_cast<const Structures*>(nullptr)), declared);
}

TEST(WireTypeList, HasEveryRegisterTypeOfTheHeaders) {
  const auto declared = structs_with("from_raw");
  EXPECT_THAT(declared, ::testing::Contains("AlStatus"));
  EXPECT_EQ(names<RegisterSample>(static_cast<const RegisterTypes*>(nullptr)), declared);
}

}  // namespace
}  // namespace driveline::wire::test
