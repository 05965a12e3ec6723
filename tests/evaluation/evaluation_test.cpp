// The evaluation against cases with known answers, and against the judge that was written apart from it.
#include "evaluation/evaluation.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>

#include "support/temp_folder.hpp"

namespace onemap::evaluation {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using testing::HasSubstr;
using Trajectory = std::vector<TimedPose>;

Isometry3d pose(const Vector3d& t, double angle_rad, const Vector3d& axis) {
  Isometry3d T = Isometry3d::Identity();
  T.linear() = AngleAxisd(angle_rad, axis.normalized()).toRotationMatrix();
  T.translation() = t;
  return T;
}

// A curve in space with turning; phase tells robots apart.
Isometry3d on_curve(double t, double phase) {
  return pose({std::sin(t + phase), 0.5 * std::cos(1.3 * t), 0.3 * t}, 0.8 * t + phase, {1, std::sin(t), 0.4});
}

Trajectory curve(double rate_hz, int count, double phase) {
  Trajectory trajectory;
  for (int i = 0; i < count; ++i) {
    const double t = i / rate_hz;
    trajectory.push_back({1000 + t, on_curve(t, phase)});
  }
  return trajectory;
}

// Uniform in -1..1, the same on every machine.
class Noise {
 public:
  explicit Noise(std::uint64_t seed) : state_(seed) {}
  double operator()() {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<double>(state_ >> 11) / 4503599627370496.0 - 1;
  }
  Vector3d vector() { return {(*this)(), (*this)(), (*this)()}; }

 private:
  std::uint64_t state_;
};

// Seen from another frame, with errors up to metres and radians, and stamped up to jitter_s beside the truth.
Trajectory disturbed(Trajectory trajectory, const Isometry3d& T_other_world, double metres, double radians,
                     double jitter_s, std::uint64_t seed) {
  Noise noise(seed);
  for (TimedPose& p : trajectory) {
    p.T_world_camera =
        T_other_world * p.T_world_camera * pose(metres * noise.vector(), radians * noise(), noise.vector());
    p.time_s += jitter_s * noise();
  }
  return trajectory;
}

std::string to_tum(const Trajectory& trajectory) {
  std::string text = "# timestamp tx ty tz qx qy qz qw\n";
  for (const TimedPose& p : trajectory) {
    const Vector3d t = p.T_world_camera.translation();
    const Eigen::Quaterniond q(p.T_world_camera.linear());
    text += fmt::format("{:.6f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n", p.time_s, t.x(), t.y(), t.z(),
                        q.x(), q.y(), q.z(), q.w());
  }
  return text;
}

RobotTrajectories robot(const std::string& name, Trajectory estimate, Trajectory truth) {
  return {name, name + "-truth", std::move(estimate), std::move(truth), std::nullopt};
}

const Isometry3d kElsewhere = pose({3, -2, 1}, 1.1, {1, 2, 3});

TEST(Evaluation, AMovedCopyHasNoError) {
  const Trajectory truth = curve(30, 200, 0);
  const auto result = evaluate({robot("a", disturbed(truth, kElsewhere, 0, 0, 0, 1), truth)}, {});
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->poses, 200u);
  EXPECT_EQ(result->coverage, 1);
  EXPECT_LT(result->ate, 1e-12);
  EXPECT_LT(result->robots[0].rpe->translation_m, 1e-12);
  EXPECT_LT(result->robots[0].rpe->rotation_deg, 1e-5);
}

TEST(Evaluation, KnownOffsetsGiveKnownErrors) {
  // A square, enlarged by 1 %: no rigid motion helps.
  Trajectory truth, estimate;
  const Vector3d corners[] = {{1, 1, 0}, {-1, 1, 0}, {-1, -1, 0}, {1, -1, 0}};
  for (int i = 0; i < 4; ++i) {
    truth.push_back({double(i), pose(corners[i], 0, {0, 0, 1})});
    estimate.push_back({double(i), pose(corners[i] * 1.01, 0, {0, 0, 1})});
  }
  const auto result = evaluate({robot("a", estimate, truth)}, {});
  ASSERT_TRUE(result.ok());
  const double expected = 0.01 * std::sqrt(2.0);
  EXPECT_NEAR(result->ate, expected, 1e-12);
  EXPECT_NEAR(result->median, expected, 1e-12);
  EXPECT_NEAR(result->max, expected, 1e-12);
  EXPECT_NEAR(result->robots[0].rpe->translation_m, 0.02, 1e-12);  // a side of 2 m is 1 % too long
}

TEST(Evaluation, ATurnBetweenPosesIsTheRelativeRotation) {
  Trajectory truth = curve(10, 50, 0), estimate = truth;
  for (std::size_t i = 0; i < truth.size(); ++i) {  // the estimate turns 3 degrees a second, the truth does not
    const double angle = static_cast<double>(i) * 0.3 * std::numbers::pi / 180;
    truth[i].T_world_camera.linear().setIdentity();
    estimate[i].T_world_camera.linear() = AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix();
  }
  const auto result = evaluate({robot("a", estimate, truth)}, {});
  ASSERT_TRUE(result.ok());
  EXPECT_NEAR(result->robots[0].rpe->rotation_deg, 3, 1e-9);
  EXPECT_LT(result->ate, 1e-12);  // positions are the truth's
}

TEST(Evaluation, AWrongMergeCountsInTheJointErrorOnly) {
  const Trajectory a = curve(30, 150, 0), b = curve(30, 150, 2);
  const auto right = evaluate(
      {robot("a", disturbed(a, kElsewhere, 0, 0, 0, 1), a), robot("b", disturbed(b, kElsewhere, 0, 0, 0, 2), b)}, {});
  const Isometry3d wrong_place = kElsewhere * pose({0.5, 0, 0}, 0, {0, 0, 1});
  const auto wrong = evaluate(
      {robot("a", disturbed(a, kElsewhere, 0, 0, 0, 1), a), robot("b", disturbed(b, wrong_place, 0, 0, 0, 2), b)}, {});
  ASSERT_TRUE(right.ok() && wrong.ok());
  EXPECT_LT(right->ate, 1e-12);
  EXPECT_GT(wrong->ate, 0.1);
  EXPECT_LT(wrong->robots[1].ate_alone, 1e-12);
}

TEST(Evaluation, CoverageIsByTheSequence) {
  const Trajectory truth = curve(30, 100, 0);
  RobotTrajectories one = robot("a", Trajectory(truth.begin(), truth.begin() + 50), truth);
  EXPECT_EQ(evaluate({one}, {})->coverage, 1);
  one.sequence_frames = 100;
  EXPECT_EQ(evaluate({one}, {})->coverage, 0.5);
}

TEST(Evaluation, AlignNeverMirrors) {
  Eigen::Matrix3Xd a(3, 4), mirrored;
  a << 1, 0, 0, 0, 0, 2, 0, 0, 0, 0, 0.1, 0;
  mirrored = a;
  mirrored.row(0) *= -1;
  EXPECT_NEAR(align(a, mirrored).linear().determinant(), 1, 1e-12);
}

TEST(Evaluation, TooFewMatchesAreAnError) {
  const Trajectory truth = curve(30, 100, 0);
  Trajectory late = truth;
  for (TimedPose& p : late) p.time_s += 500;
  const auto result = evaluate({robot("a", late, truth)}, {});
  ASSERT_FALSE(result.ok());
  EXPECT_THAT(result.error().text(), HasSubstr("a: only 0 poses match a-truth"));
}

TEST(Evaluation, TrajectoriesAreReadWithCommentsCommasAndCrlf) {
  const auto poses = parse_trajectory("# t\r\n\r\n2,1,2,3,0,0,0,2\r\n1.5 0 0 0 0 0 0 +1 # first\n", "f");
  ASSERT_TRUE(poses.ok()) << poses.error().text();
  ASSERT_EQ(poses->size(), 2u);
  EXPECT_EQ((*poses)[0].time_s, 1.5);
  EXPECT_EQ((*poses)[1].T_world_camera.translation(), Vector3d(1, 2, 3));
  EXPECT_TRUE((*poses)[1].T_world_camera.linear().isIdentity());
  EXPECT_EQ(count_listed_frames("# x\n1 a 1 b\n\n  \r\n2 c 2 d"), 2u);
}

TEST(Evaluation, BadInputIsNamedWithItsLine) {
  const std::pair<const char*, const char*> cases[] = {{"1 2 3", "f:1: 3 values where 8 are expected"},
                                                       {"#\n1 0 0 0 0 0 0 x", "f:2: 'x' is not a finite number"},
                                                       {"nan 0 0 0 0 0 0 1", "f:1: 'nan' is not a finite number"},
                                                       {"1 0 0 0 0 0 0 0", "f:1: the quaternion is zero"},
                                                       {"# nothing\n", "f: no poses"}};
  for (const auto& [text, expected] : cases) {
    const auto poses = parse_trajectory(text, "f");
    ASSERT_FALSE(poses.ok());
    EXPECT_EQ(poses.error().text(), expected);
  }
}

struct Output {
  int status = -1;
  std::string text;  // standard output and error
};

Output run(const std::string& command) {
  Output output;
  std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  if (!pipe) return output;
  char buffer[4096];
  while (const std::size_t size = std::fread(buffer, 1, sizeof buffer, pipe)) output.text.append(buffer, size);
  const int status = pclose(pipe);
  if (WIFEXITED(status)) output.status = WEXITSTATUS(status);
  return output;
}

const std::string kProgram = std::string(ONEMAP_BIN_DIR) + "/onemap-eval ";
const std::string kJudge = std::string(ONEMAP_SHARED_DIR) + "/tools/trajectory_error.py";

void expect_near(const nlohmann::json& ours, const nlohmann::json& judge, const std::string& where) {
  ASSERT_EQ(ours.is_number(), judge.is_number()) << where;
  if (judge.is_number()) {
    EXPECT_NEAR(ours.get<double>(), judge.get<double>(), 1e-6) << where;
    return;
  }
  ASSERT_EQ(ours.size(), judge.size()) << where;
  if (judge.is_object())
    for (const auto& [key, value] : judge.items()) {
      ASSERT_TRUE(ours.contains(key)) << where << "." << key;
      expect_near(ours[key], value, where + "." + key);
    }
  if (judge.is_array())
    for (std::size_t i = 0; i < judge.size(); ++i) expect_near(ours[i], judge[i], where + "." + std::to_string(i));
  if (judge.is_string() || judge.is_null()) {
    EXPECT_EQ(ours, judge) << where;
  }
}

// A floor at z = 0 in the truth's frame, of which the map has points 1 to 100 mm above it.
TEST(Surface, ErrorIsTheDistanceFromTheTrueSurfaceInTheTruthsFrame) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 1; i <= 100; ++i)
    points.push_back((kElsewhere.inverse() * Eigen::Vector3d(0.1 * i, 2, 0.001 * i)).cast<float>());
  const auto floor = [](const std::array<double, 3>& at) { return std::abs(at[2]); };
  const SurfaceEvaluation surface = evaluate_surface(points, kElsewhere, floor);
  EXPECT_EQ(surface.points, 100u);
  EXPECT_NEAR(surface.rms, 0.0581, 1e-4);  // sqrt(101 * 201 / 6) mm
  EXPECT_NEAR(surface.median, 0.051, 1e-4);
  EXPECT_NEAR(surface.p95, 0.096, 1e-4);
  EXPECT_NEAR(surface.off, 0.70, 0.011);
  TeamEvaluation team;
  EXPECT_EQ(to_table(team, {}).find("surface"), std::string::npos);
  team.surface = surface;
  EXPECT_NE(to_table(team, {}).find("surface: 100 points, 0.0582 m rms, median 0.0510 m, 95 % within 0.0960 m, "),
            std::string::npos)
      << to_table(team, {});
  EXPECT_NEAR(nlohmann::json::parse(to_json(team)).at("surface").at("rms").get<double>(), surface.rms, 1e-9);
}

// A robot that hardly moved, its places noisy by a millimetre: they do not say which way is up, the gazes do.
TEST(Surface, TheFrameIsThatOfPlacesAndGazes) {
  Trajectory truth = curve(30, 60, 0);
  for (TimedPose& pose : truth) pose.T_world_camera.translation() *= 0.002;
  const auto result = evaluate({robot("a", disturbed(truth, kElsewhere, 0.001, 0, 0, 3), truth)}, {});
  ASSERT_TRUE(result.ok());
  const Isometry3d off = result->T_truth_estimate * kElsewhere;
  EXPECT_LT(Eigen::AngleAxisd(off.linear()).angle(), 0.002);
}

TEST(EvaluationProgram, TheTableSaysItsUnits) {
  const Trajectory truth = curve(30, 200, 0);
  const auto result = evaluate({robot("a", disturbed(truth, kElsewhere, 0, 0, 0, 1), truth)}, {});
  ASSERT_TRUE(result.ok());
  const std::string table = to_table(*result, {});
  EXPECT_NE(table.find("RPE 1 s"), std::string::npos) << table;
  EXPECT_NE(table.find(" m          m          m          m       deg\n"), std::string::npos) << table;
  EXPECT_NE(table.find("deg\n   200     1.000     0.0000"), std::string::npos) << table;
  EXPECT_NE(table.find("team of 1: 200 poses, coverage 1.000, ATE 0.0000 m, median 0.0000 m, max 0.0000 m\n"),
            std::string::npos)
      << table;
}

// Of ten frames the estimate has those of a part.
TEST(EvaluationProgram, CoverageOfAPartIsOfThePart) {
  const test::TempFolder folder;
  std::string list, truth, estimate;
  for (int i = 0; i < 10; ++i) {
    const std::string pose = fmt::format("{}.0 {} {} 0 0 0 0 1\n", i, i, i * i % 7);
    list += fmt::format("{0}.0 rgb/{0}.png {0}.0 depth/{0}.png\n", i);
    truth += pose;
    if (i >= 3 && i < 7) estimate += pose;
  }
  folder.write("associations.txt", list);
  folder.write("groundtruth.txt", truth);
  folder.write("estimate.txt", estimate);
  const std::string start = kProgram + (folder / "estimate.txt") + " ", recording = folder.path().string();
  EXPECT_NE(run(start + recording + "/groundtruth.txt").text.find("coverage 0.400"), std::string::npos);
  const Output part = run(start + "replay:" + recording + ":3:7");
  EXPECT_NE(part.text.find("coverage 1.000"), std::string::npos) << part.text;
  const Output whole = run(start + "replay:" + recording);
  EXPECT_NE(whole.text.find("coverage 0.400"), std::string::npos) << whole.text;
  const Output late = run(start + "replay:" + recording + ":3:99");
  EXPECT_NE(late.text.find("coverage 0.571"), std::string::npos) << late.text;  // four of the last seven
  EXPECT_EQ(run(start + "replay:" + recording + ":10:12").status, 1);
}

class AgainstTheJudge : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kJudge)) GTEST_SKIP() << "the judge " << kJudge << " is not here";
    if (run("/usr/bin/python3 -c 'import numpy'").status != 0) GTEST_SKIP() << "python3 with numpy is not here";
  }
  void compare(const std::string& arguments) {
    const Output judge = run("/usr/bin/python3 " + kJudge + " " + arguments + " --json");
    const Output ours = run(kProgram + arguments + " --json");
    ASSERT_EQ(judge.status, 0) << judge.text;
    ASSERT_EQ(ours.status, 0) << ours.text;
    expect_near(nlohmann::json::parse(ours.text), nlohmann::json::parse(judge.text), arguments);
    EXPECT_EQ(run(kProgram + arguments).text, run("/usr/bin/python3 " + kJudge + " " + arguments).text);
  }
  test::TempFolder folder_;
};

TEST_F(AgainstTheJudge, TeamsWithNoiseGapsAndUnsortedLinesAgree) {
  std::string team;
  for (int i = 0; i < 4; ++i) {
    const std::string name = "robot" + std::to_string(i);
    const Isometry3d frame = i == 3 ? pose({0.3, 0, 0}, 0.05, {0, 1, 0}) * kElsewhere : kElsewhere;
    Trajectory estimate = disturbed(curve(30, 300, i), frame, 0.02, 0.03, 0.006, static_cast<std::uint64_t>(i + 7));
    estimate.erase(estimate.begin() + 40, estimate.begin() + 60 + 10 * i);
    std::swap(estimate[3], estimate[90]);
    folder_.write(name + "/estimate.txt", to_tum(estimate));
    folder_.write(name + "/truth.txt", to_tum(curve(100, 970, i)));
    std::string list = "# list\n";
    for (int k = 0; k < 310; ++k) list += "1 a 1 b\n";
    if (i % 2 == 0) folder_.write(name + "/associations.txt", list);
    const std::string pair = folder_ / name + "/estimate.txt " + (folder_ / name) + "/truth.txt ";
    compare(pair);
    team += pair;
  }
  compare(team);
  compare(team + "--rpe 0.5 --max-dt 0.004");
  compare(team + "--rpe 100");  // longer than the sequence: no RPE
}

TEST_F(AgainstTheJudge, AgreesOnARecordedTruth) {
  const std::string truth = std::string(ONEMAP_SHARED_DIR) + "/data/fr1_xyz/groundtruth.txt";
  if (!std::filesystem::exists(truth)) GTEST_SKIP() << "the recording " << truth << " is not here";
  const Output text = run("cat " + truth);
  const auto poses = parse_trajectory(text.text, truth);
  ASSERT_TRUE(poses.ok());
  folder_.write("estimate.txt", to_tum(disturbed(*poses, kElsewhere, 0.01, 0.01, 0.006, 5)));
  compare(folder_ / "estimate.txt " + truth);
}

TEST(OnemapEval, BadOptionsEndWithTwoAndBadFilesWithOne) {
  const test::TempFolder folder;
  folder.write("good.txt", to_tum(curve(30, 10, 0)));
  folder.write("bad.txt", "1 0 0 0 0 0 0 1\n1 2 3\n");
  const std::string good = folder / "good.txt ", bad = folder / "bad.txt ";
  EXPECT_EQ(run(kProgram + good + good).status, 0);
  const Output named = run(kProgram + good + bad);
  EXPECT_EQ(named.status, 1);
  EXPECT_THAT(named.text, HasSubstr("bad.txt:2: 3 values where 8 are expected"));
  for (const std::string& arguments :
       {std::string(), good, good + good + "--rpe 0", good + good + "--rpe nan", good + good + "--max-dt -1",
        good + good + "--max-dt nan", good + good + "--max-dt inf", good + good + "--fast"})
    EXPECT_EQ(run(kProgram + arguments).status, 2) << arguments;
  for (const std::string& arguments : {good + "/nowhere", good + "/tmp"})
    EXPECT_EQ(run(kProgram + arguments).status, 1) << arguments;
  const Output help = run(kProgram + "--help");
  EXPECT_EQ(help.status, 0);
  EXPECT_THAT(help.text, testing::AllOf(HasSubstr("EST GT"), HasSubstr("--max-dt"), HasSubstr("--json")));
}

}  // namespace
}  // namespace onemap::evaluation
