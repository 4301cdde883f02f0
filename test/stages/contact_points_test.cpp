#include "ipm_mapping/stages/contact_points.hpp"

#include <gtest/gtest.h>

#include "ipm_mapping/parameters.hpp"
#include "ipm_mapping/stages/obstacle_mask.hpp"
#include "support/pictures.hpp"

namespace ipm_mapping::test {
namespace {

const Focus upright{Eigen::Vector3d(0, 1, 0)};

/// Fills columns u - half ... u + half of a row.
void bar(Picture& picture, int u, int half, int v, std::uint8_t value = mask::obstacle) {
  for (int k = u - half; k <= u + half; ++k)
    if (picture.view().contains(k, v)) picture(k, v) = value;
}

/// A triangle with its vertex (one pixel wide) at (u, tip) that widens upwards, two pixels a row.
void triangle(Picture& picture, int u, int tip, int rows) {
  for (int k = 0; k < rows; ++k) bar(picture, u, k, tip - k);
}

// ---- the source's machine ---------------------------------------------------------------------

struct Word {
  bool flag = false;
  int u = 0, v = 0;
};

/// Eq. 5.6-5.16 with the hardware's registers, pixel by pixel of one line: B starts at the widest
/// window, the pair (u, v) is stored in every accepted row, and the triangle is judged at the first
/// background pixel and after the last row. The last contact wins.
Word hardwareMachine(const PolarBeam& beam, int line, const Picture& picture, bool triangle_method,
                     int score_min, int min_height, int min_width) {
  const int widest = 11;
  int B = widest, S = 0, h = 0, Sc = 0, stored_u = 0, stored_v = 0;
  Word word;
  const auto judge = [&] {
    if (Sc > score_min && S > min_width * h && h >= min_height) word = {true, stored_u, stored_v};
    B = widest;
    S = h = Sc = 0;
  };
  for (int v = 0; v < picture.height(); ++v) {
    const int u = beam.columns(line)[v];
    const bool pixel = u >= 0 && picture(u, v) == mask::obstacle;
    if (!pixel) {
      judge();
      continue;
    }
    int a = 0;
    for (int k = u - 5; k <= u + 5; ++k)
      a += picture.view().contains(k, v) && picture(k, v) == mask::obstacle;
    if (a <= B) {
      B = a;
      S += a;
      ++h;
      ++Sc;
      stored_u = u;
      stored_v = v;
    } else {
      B = widest;
      if (triangle_method) {
        --Sc;
      } else {
        Sc = 0;
        S = h = 0;
      }
    }
  }
  judge();
  return word;
}

/// Triangles, bars, speckle and unseen patches: what a mask holds, and worse.
Picture scribble(std::mt19937& random) {
  Picture picture(160, 120);
  for (int k = draw(random, 1, 8); k > 0; --k)
    triangle(picture, draw(random, 0, 159), draw(random, 5, 119), draw(random, 3, 40));
  for (int k = draw(random, 0, 6); k > 0; --k) {
    const int u = draw(random, 0, 159), half = draw(random, 0, 8), top = draw(random, 0, 100);
    for (int v = top; v < std::min(top + draw(random, 1, 40), 120); ++v)
      bar(picture, u, half + draw(random, -1, 1), v);
  }
  for (int k = draw(random, 0, 400); k > 0; --k)
    picture(draw(random, 0, 159), draw(random, 0, 119)) =
        draw(random, 0, 1) ? mask::floor : mask::obstacle;
  for (int k = draw(random, 0, 3); k > 0; --k) {
    const int u = draw(random, 0, 159), v = draw(random, 0, 119);
    for (int row = v; row < std::min(v + 15, 120); ++row) bar(picture, u, 12, row, mask::unseen);
  }
  return picture;
}

TEST(PaperContacts, EqualTheHardwareMachine) {
  std::mt19937 random(30);
  int contacts = 0;
  for (int round = 0; round < 400; ++round) {
    LocalizationParameters parameters = Parameters::profile("paper").localization;
    parameters.method = round % 2 ? ContactMethod::Score : ContactMethod::Triangle;
    parameters.score_min = draw(random, 0, 8);
    parameters.min_height = draw(random, 1, 9);
    const Picture picture = scribble(random);
    const Focus focus{Eigen::Vector3d(draw(random, -200, 360), draw(random, 60, 900), 1)};
    PolarBeam beam;
    ASSERT_TRUE(beam.aim(focus, 160, 120, 80, Beam::Source));
    ContactFinder finder;
    std::vector<LineContacts> lines;
    beam.sample(picture.view());
    finder.find(beam, picture.view(), parameters, lines);
    ASSERT_EQ(lines.size(), 80U);
    for (int i = 0; i < 80; ++i) {
      const Word expected =
          hardwareMachine(beam, i, picture, parameters.method == ContactMethod::Triangle,
                          parameters.score_min, parameters.min_height, 4);
      const int index = lines[static_cast<std::size_t>(i)].nearest;
      ASSERT_EQ(index >= 0, expected.flag) << "round " << round << " line " << i;
      if (index < 0) continue;
      const TriangleContact& found = finder.contacts()[static_cast<std::size_t>(index)];
      ASSERT_EQ(found.line, i);
      ASSERT_EQ(found.u, expected.u) << "round " << round << " line " << i;
      ASSERT_EQ(found.v, expected.v) << "round " << round << " line " << i;
      ++contacts;
    }
  }
  EXPECT_GT(contacts, 2000);
}

// ---- hand-drawn triangles with the default settings ---------------------------------------------

constexpr int line = 40;  // of 80 upright lines over 641 columns
constexpr int column = 324;

struct Answer {
  std::vector<TriangleContact> contacts;  ///< of the line
  int nearest_row = -1;
  int blocked_row = -1;
};

Answer follow(const Picture& picture, const LocalizationParameters& parameters = {}) {
  PolarBeam beam;
  EXPECT_TRUE(beam.aim(upright, picture.width(), picture.height(), 80, Beam::FullView));
  EXPECT_EQ(beam.columns(line)[0], column);
  ContactFinder finder;
  std::vector<LineContacts> lines;
  beam.sample(picture.view());
  finder.find(beam, picture.view(), parameters, lines);
  Answer answer;
  answer.blocked_row = lines[line].blocked_row;
  if (lines[line].nearest >= 0)
    answer.nearest_row = finder.contacts()[static_cast<std::size_t>(lines[line].nearest)].v;
  for (const TriangleContact& c : finder.contacts())
    if (c.line == line) answer.contacts.push_back(c);
  return answer;
}

TEST(Contact, IsTheVertexOfATriangle) {
  Picture picture(641, 100);
  triangle(picture, column, 60, 20);
  const Answer answer = follow(picture);
  ASSERT_EQ(answer.contacts.size(), 1U);
  EXPECT_EQ(answer.contacts[0].u, column);
  EXPECT_EQ(answer.contacts[0].v, 60);
  EXPECT_EQ(answer.contacts[0].height, 20);
  EXPECT_EQ(answer.contacts[0].score, 20);
  EXPECT_EQ(answer.contacts[0].surface, 1 + 3 + 5 + 7 + 9 + 15 * 11);
  EXPECT_EQ(answer.nearest_row, 60);
  EXPECT_EQ(answer.blocked_row, -1);
}

TEST(Contact, SurvivesAGapOfMaxGapPixelsAndNoLonger) {
  for (const int gap : {1, 2, 3}) {
    Picture picture(641, 100);
    triangle(picture, column, 60, 25);
    for (int k = 0; k < gap; ++k) bar(picture, column, 40, 50 + k, mask::floor);
    const Answer answer = follow(picture);
    EXPECT_EQ(answer.contacts.size(), gap <= 2 ? 1U : 2U) << gap;
    EXPECT_EQ(answer.contacts.back().v, 60) << gap;
    EXPECT_EQ(answer.contacts.front().v, gap <= 2 ? 60 : 49) << gap;
  }
}

TEST(Contact, OfTwoTrianglesOnALineTheLowerIsTheNearest) {
  Picture picture(641, 100);
  triangle(picture, column, 30, 15);
  triangle(picture, column, 80, 15);
  const Answer answer = follow(picture);
  ASSERT_EQ(answer.contacts.size(), 2U);
  EXPECT_EQ(answer.contacts[0].v, 30);
  EXPECT_EQ(answer.contacts[1].v, 80);
  EXPECT_EQ(answer.nearest_row, 80);
}

TEST(Contact, IsTheLowestRowOfTheSmallestWidth) {
  // Below the waist (3 wide, rows 50 and 51) the shape widens and shrinks again, less far.
  Picture picture(641, 100);
  for (int v = 30; v < 50; ++v) bar(picture, column, 5, v);
  bar(picture, column, 1, 50);
  bar(picture, column, 1, 51);
  for (int v = 52; v < 56; ++v) bar(picture, column, 4, v);
  bar(picture, column, 2, 56);
  LocalizationParameters parameters;
  EXPECT_EQ(follow(picture, parameters).contacts.at(0).v, 51);
  parameters.lowest_minimum = false;
  EXPECT_EQ(follow(picture, parameters).contacts.at(0).v, 56);
}

TEST(Contact, NeedsHeightScoreAndWidth) {
  LocalizationParameters parameters;
  parameters.score_min = 0;
  for (const int rows : {4, 5}) {
    Picture low(641, 100);
    for (int v = 60 - rows; v < 60; ++v) bar(low, column, 4, v);
    EXPECT_EQ(follow(low, parameters).contacts.size(), rows == 5 ? 1U : 0U) << rows;
  }
  for (const int rows : {8, 9}) {
    parameters.score_min = 8;
    Picture picture(641, 100);
    for (int v = 60 - rows; v < 60; ++v) bar(picture, column, 4, v);
    EXPECT_EQ(follow(picture, parameters).contacts.size(), rows == 9 ? 1U : 0U) << rows;
  }
  for (const int half : {1, 2}) {  // 3 wide: S = 3h; 5 wide: S = 5h
    Picture thin(641, 100);
    for (int v = 40; v < 60; ++v) bar(thin, column, half, v);
    EXPECT_EQ(follow(thin).contacts.size(), half == 2 ? 1U : 0U) << half;
  }
}

TEST(Contact, IsRefusedWhereTheShapeMostlyWidens) {
  // Upside down: every second row widens, so that Sc stays near 0.
  Picture picture(641, 100);
  for (int k = 0; k < 24; ++k) bar(picture, column, k % 2 ? 5 : 2, 40 + k);
  const Answer answer = follow(picture);
  EXPECT_TRUE(answer.contacts.empty());
  EXPECT_EQ(answer.blocked_row, 63);
}

TEST(Contact, ScoreMethodStartsAnewWhereTheShapeWidens) {
  // Ten good rows, one wider row, then four: enough for the triangle method only.
  Picture picture(641, 100);
  for (int v = 40; v < 50; ++v) bar(picture, column, 3, v);
  bar(picture, column, 5, 50);
  for (int v = 51; v < 55; ++v) bar(picture, column, 3, v);
  LocalizationParameters parameters;
  EXPECT_EQ(follow(picture, parameters).contacts.size(), 1U);
  parameters.method = ContactMethod::Score;
  EXPECT_EQ(follow(picture, parameters).contacts.size(), 0U);
}

TEST(ClippedTriangle, AtTheLowerBorderBlocksWithoutAContact) {
  Picture picture(641, 100);
  triangle(picture, column, 105, 30);
  const Answer answer = follow(picture);
  EXPECT_TRUE(answer.contacts.empty());
  EXPECT_EQ(answer.blocked_row, 99);
  LocalizationParameters paper;
  paper.clipped_contacts = true;
  EXPECT_EQ(follow(picture, paper).contacts.at(0).v, 99);
}

TEST(ClippedTriangle, ByUnseenPixelsBlocksWithoutAContact) {
  for (const int rim : {0, 1, 2}) {  // the erosion leaves up to two floor pixels before unseen ones
    Picture picture(641, 100);
    triangle(picture, column, 70, 30);
    for (int v = 60; v < 100; ++v)
      bar(picture, column, 60, v, v < 60 + rim ? mask::floor : mask::unseen);
    const Answer answer = follow(picture);
    EXPECT_TRUE(answer.contacts.empty()) << rim;
    EXPECT_EQ(answer.blocked_row, 59) << rim;
  }
}

TEST(ClippedTriangle, DoesNotHideTheContactAboveIt) {
  Picture picture(641, 100);
  triangle(picture, column, 40, 20);
  triangle(picture, column, 110, 30);
  const Answer answer = follow(picture);
  ASSERT_EQ(answer.contacts.size(), 1U);
  EXPECT_EQ(answer.contacts[0].v, 40);
  EXPECT_EQ(answer.blocked_row, 99);
}

TEST(Blocked, NeedsMinOccupiedPixels) {
  for (const int rows : {4, 5}) {
    Picture picture(641, 100);
    for (int v = 60 - rows; v < 60; ++v) bar(picture, column, 0, v);
    const Answer answer = follow(picture);
    EXPECT_TRUE(answer.contacts.empty());
    EXPECT_EQ(answer.blocked_row, rows == 5 ? 59 : -1);
  }
}

TEST(WindowSum, CountsOutsideAsBackground) {
  std::mt19937 random(31);
  const Picture picture = speckle(23, 1, random, 0.6);
  for (int half = 1; half <= 31; half += 5) {
    for (int u = 0; u < 23; ++u) {
      int expected = 0;
      for (int k = -half; k <= half; ++k)
        expected += picture.view().contains(u + k, 0) && picture(u + k, 0) == 255;
      EXPECT_EQ(windowSum(picture.view().row(0), 23, u, half), expected);
    }
  }
}

TEST(ContactFinder, GivesTheSameAnswerWhenReused) {
  std::mt19937 random(32);
  const Picture first = scribble(random), second = scribble(random);
  PolarBeam beam;
  ASSERT_TRUE(beam.aim(upright, 160, 120, 80, Beam::FullView));
  ContactFinder fresh, reused;
  std::vector<LineContacts> a, b;
  beam.sample(first.view());
  reused.find(beam, first.view(), {}, b);
  beam.sample(second.view());
  reused.find(beam, second.view(), {}, b);
  fresh.find(beam, second.view(), {}, a);
  ASSERT_EQ(fresh.contacts().size(), reused.contacts().size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].nearest, b[i].nearest);
    EXPECT_EQ(a[i].blocked_row, b[i].blocked_row);
  }
}

}  // namespace
}  // namespace ipm_mapping::test
