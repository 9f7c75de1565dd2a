#pragma once

#include <cstdint>
#include <span>
#include <string_view>

/// What driveline-dds knows of topics and their types; the tables are made from the IDL by make_topics.py.
namespace driveline::bridge::clients {

/// Of a field, or of the elements of a sequence.
enum class Kind : std::uint8_t {
  kBool,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat,
  kDouble,
  kString,
  kEnum,
  kStruct,
};

/// An enumeration, on the wire a number of 32 bits.
struct EnumType {
  std::span<const std::string_view> names;  ///< by value
};

struct StructType;

/// A field of a structure.
struct Field {
  std::string_view name;
  Kind kind;
  bool sequence;                ///< of `kind`
  std::uint32_t count;          ///< elements of an array; 0: it is none
  bool key;                     ///< tells instances of the topic apart
  const EnumType* enumeration;  ///< kEnum only
  const StructType* structure;  ///< kStruct only
};

/// A structure.
struct StructType {
  std::string_view name;  ///< as ROS 2 has it: "driveline/Event"
  std::span<const Field> fields;
};

/// A topic, how it is read, and how its samples are counted and become rows. Names of fields are empty where there is
/// none.
struct Topic {
  std::string_view name;    ///< "driveline/v1/event"
  std::string_view type;    ///< on the wire: "driveline::telemetry::Event"
  std::string_view schema;  ///< name of the type in a recording: "driveline/msg/Event"
  std::string_view text;    ///< its definition there (ros2msg)
  const StructType* structure;
  bool kept;                       ///< the writer keeps samples for who comes late
  std::string_view counter;        ///< field that counts samples
  std::string_view counter_of;     ///< field that tells who counts
  std::string_view rows;           ///< sequence whose elements are the rows of a table
  std::string_view partner_index;  ///< field of such an element: index into `partners`
  std::string_view partners;       ///< sequence whose elements belong to rows
};

/// All topics, in the order of the documents.
[[nodiscard]] std::span<const Topic> topics() noexcept;
/// Null: there is none of that name.
[[nodiscard]] const Topic* find_topic(std::string_view name) noexcept;

}  // namespace driveline::bridge::clients
