#include "common/base/byte_io.h"

#include <array>
#include <cstdint>
#include <limits>
#include <string>

#include <gtest/gtest.h>

namespace cohort {
namespace {

TEST(ByteWriter, WritesLittleEndian) {
  ByteWriter writer;
  writer.Put(uint32_t{0x01020304});
  writer.Put(uint8_t{0xff});

  EXPECT_EQ(std::move(writer).Take(), std::string("\x04\x03\x02\x01\xff", 5));
}

TEST(ByteReader, ReadsBackWhatWasWritten) {
  const std::array<double, 3> values = {1.5, -0.0, std::numeric_limits<double>::max()};
  ByteWriter writer;
  writer.Put(int64_t{-7});
  writer.PutArray(std::span<const double>(values));
  writer.PutString(std::string_view("a\0b", 3));
  writer.PutBytes("rest");
  const std::string bytes = std::move(writer).Take();

  ByteReader reader(bytes);
  int64_t number = 0;
  std::array<double, 3> array{};
  std::string text;
  ASSERT_TRUE(reader.Get(number));
  ASSERT_TRUE(reader.GetArray(std::span<double>(array)));
  ASSERT_TRUE(reader.GetString(text));

  EXPECT_EQ(number, -7);
  EXPECT_EQ(array, values);
  EXPECT_EQ(text, std::string("a\0b", 3));
  EXPECT_EQ(reader.Rest(), "rest");
}

TEST(ByteReader, RefusesWhatIsCutShort) {
  ByteReader reader(std::string_view("\1\2\3", 3));
  uint32_t number = 0;
  std::array<uint16_t, 2> array{};

  EXPECT_FALSE(reader.Get(number));
  EXPECT_FALSE(reader.GetArray(std::span<uint16_t>(array)));
  EXPECT_EQ(reader.Remaining(), 3u);
}

TEST(ByteReader, BelievesNoLengthOfAString) {
  ByteWriter writer;
  writer.Put(std::numeric_limits<uint64_t>::max());
  writer.PutBytes("abc");
  const std::string bytes = std::move(writer).Take();
  ByteReader reader(bytes);
  std::string text;

  EXPECT_FALSE(reader.GetString(text));
}

TEST(ByteReader, ReadsAnEmptyArrayFromNothing) {
  ByteReader reader(std::string_view{});

  EXPECT_TRUE(reader.GetArray(std::span<double>()));
}

}  // namespace
}  // namespace cohort
