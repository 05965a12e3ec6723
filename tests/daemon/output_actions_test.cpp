// What clients ask of recordings and snapshots, and what they hear.
#include "daemon/control/output_actions.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>

#include "support/temp_folder.hpp"

namespace onemap::daemon {
namespace {

using test::TempFolder;
using testing::HasSubstr;

Result<Json> ask(const ControlActions::Action& action, const Json& request) {
  auto promised = std::make_shared<std::promise<Result<Json>>>();
  auto answer = promised->get_future();
  action(request, [promised](Result<Json> said) { promised->set_value(std::move(said)); });
  if (answer.wait_for(std::chrono::seconds(60)) != std::future_status::ready) return Error{"", "no answer"};
  return answer.get();
}

struct OutputActions : testing::Test {
  OutputActions() { config.out = folder.path().string(); }
  const TempFolder folder;
  Config config;
  Failures failures;
  Log log{"robot"};
};

TEST_F(OutputActions, ARecordingIsBegunAndEnded) {
  hal::Intrinsics k;
  k.width = k.height = 4;
  RecorderConfig limits;
  limits.least_free_bytes = 0;
  Recorder recorder(limits, k, "a camera", {}, log);
  const auto record = record_action(recorder, config);
  auto said = ask(record, {{"class", "RECORD"}});
  ASSERT_TRUE(said) << said.error().text();
  EXPECT_EQ(said->at("recording"), true);
  EXPECT_EQ(said->at("folder"), folder / "recordings/0001");
  EXPECT_THAT(ask(record, {{"class", "RECORD"}}).error().text(), HasSubstr("a recording is running"));
  said = ask(record, {{"class", "RECORD"}, {"enable", false}});
  ASSERT_TRUE(said);
  EXPECT_EQ(said->at("recording"), false);
  EXPECT_EQ(said->at("frames"), 0);
  EXPECT_FALSE(said->contains("ended"));
  EXPECT_TRUE(ask(record, {{"class", "RECORD"}, {"enable", false}})) << "once more does no harm";
  said = ask(record, {{"class", "RECORD"}, {"path", "desk"}});
  ASSERT_TRUE(said) << said.error().text();
  EXPECT_EQ(said->at("folder"), folder / "desk");
  EXPECT_THAT(ask(record, {{"class", "RECORD"}, {"enable", "yes"}}).error().text(), HasSubstr("enable"));
}

TEST_F(OutputActions, ASnapshotIsAnsweredWhenItIsThereOrCannotBe) {
  Snapshots snapshots(
      config, [](auto&) { return std::optional<MapCopy>(); }, failures, log);
  const auto snapshot = snapshot_action(snapshots, config);
  snapshots.start();
  EXPECT_THAT(ask(snapshot, {{"class", "SNAPSHOT"}}).error().text(), HasSubstr("left off"));
  EXPECT_THAT(ask(snapshot, {{"class", "SNAPSHOT"}, {"view", "behind"}}).error().text(),
              HasSubstr("view: 'behind' is not one of fit, top"));
  EXPECT_THAT(ask(snapshot, {{"class", "SNAPSHOT"}, {"format", "gif"}}).error().text(), HasSubstr("png, glb, plan"));
  EXPECT_THAT(ask(snapshot, {{"class", "SNAPSHOT"}, {"map", 3}}).error().text(), HasSubstr("map"));
}

}  // namespace
}  // namespace onemap::daemon
