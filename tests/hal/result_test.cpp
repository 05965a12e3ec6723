#include "hal/base/result.hpp"

#include <gtest/gtest.h>

#include <memory>

namespace onemap {
namespace {

Result<int> half(int n) {
  if (n % 2 != 0) return Error{"numbers.txt:3", "odd"};
  return n / 2;
}

TEST(Result, HoldsAValue) {
  const Result<int> result = half(8);
  ASSERT_TRUE(result.ok());
  EXPECT_TRUE(result);
  EXPECT_EQ(*result, 4);
  EXPECT_EQ(result.value(), 4);
}

TEST(Result, HoldsAnErrorWithItsPlace) {
  const Result<int> result = half(7);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().text(), "numbers.txt:3: odd");
  EXPECT_EQ((Error{"", "odd"}).text(), "odd");
}

TEST(Result, MovesOnlyValuesOut) {
  Result<std::unique_ptr<int>> result(std::make_unique<int>(5));
  const std::unique_ptr<int> taken = std::move(result).value();
  EXPECT_EQ(*taken, 5);
}

TEST(Result, ReachesMembers) {
  Result<std::string> result(std::string("abc"));
  result->push_back('d');
  EXPECT_EQ(result->size(), 4u);
}

TEST(Result, StatusIsAResultWithoutAValue) {
  EXPECT_TRUE(success().ok());
  const Status failed = Error{"disk", "full"};
  EXPECT_FALSE(failed.ok());
}

TEST(Result, TextValuesAndErrorsAreToldApart) {
  const Result<std::string> value(std::string("text"));
  const Result<std::string> error(Error{"text", "text"});
  EXPECT_TRUE(value.ok());
  EXPECT_FALSE(error.ok());
}

}  // namespace
}  // namespace onemap
