// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "DeviceBridge/Hand/HandMotion.h"
#include "demos/scenes/Grasp/GraspLoad.h"
#include "demos/scenes/Grasp/GraspReport.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>

using namespace devicebridge;
using namespace scenes;
using ist::Vec3;

namespace
{
std::unique_ptr<GraspScene> makeScene(const std::string& object, bool left = false, double length = 0.189)
{
	GraspOptions options;
	options.object = object;
	options.cache = TREE_FOLDER;
	options.left = left;
	options.handLength = length;
	auto scene = GraspScene::make(options);
	EXPECT_TRUE(scene) << scene.error().message;
	return scene ? std::move(scene).value() : nullptr;
}

const BulletHandSettings kSettings;

/// Checks the conditions that hold for every grasp.
void expectSound(const GraspOutcome& outcome)
{
	// When a bone of 0.03 kg is stopped within a step, its force includes the momentum that its coupling had given it.
	EXPECT_LE(outcome.peakForce, 1.02 * kSettings.maxForce);
	EXPECT_LE(outcome.couplingForce, kSettings.maxForce * (1 + 1e-9));
	EXPECT_EQ(outcome.complaints, "");
	// All energy is accounted for.
	EXPECT_LT(std::fabs(outcome.energy.residual), 2e-3 * outcome.energy.injected);
	EXPECT_GT(outcome.energy.physical, 0);
}
}  // namespace

class GraspScenario : public testing::TestWithParam<std::string>
{};

TEST_P(GraspScenario, HoldsWithFrictionAndDropsWithout)
{
	const auto scene = makeScene(GetParam());
	ASSERT_TRUE(scene);
	const GraspOutcome rough = runGrasp(*scene, 0.5).value();
	expectSound(rough);
	EXPECT_TRUE(rough.held);
	EXPECT_TRUE(rough.putDown);
	EXPECT_LT(rough.slip, 0.004);
	EXPECT_LT(rough.slipAngle, 0.15);
	EXPECT_TRUE(rough.quality.forceClosure);
	EXPECT_GT(rough.quality.epsilon, 0.02);
	EXPECT_LT(rough.quality.epsilon, 0.5);
	EXPECT_GE(rough.parts, 2);
	// Friction can carry the weight only with at least this pressing force.
	EXPECT_GT(0.5 * rough.holdingForce, scene->object().mass * 9.81);

	const GraspOutcome smooth = runGrasp(*scene, 0.04).value();
	expectSound(smooth);
	EXPECT_FALSE(smooth.held);
	// It lies on the table. The hand that opens may push it once more, and it still slides at the end.
	EXPECT_LT(smooth.samples.back().height, GraspOutcome::kOffTable);
}
INSTANTIATE_TEST_SUITE_P(Objects, GraspScenario, testing::ValuesIn(graspObjectNames()), [](const auto& row) { return row.param; });

namespace
{
/// A mesh in a file with z up, for the time of a test.
struct ZUpFile
{
	std::string path = (std::filesystem::temp_directory_path() / ("object" + std::to_string(std::random_device()()) + ".obj")).string();

	explicit ZUpFile(const ist::Mesh& mesh)
	{
		std::ofstream out(path);
		for (const Vec3& v : mesh.vertices) out << "v " << v.x << ' ' << v.y << ' ' << v.z << '\n';
		for (const auto& t : mesh.triangles) out << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
	}
	~ZUpFile() { std::filesystem::remove(path); }
};

ist::Result<GraspReportOutcome> graspOf(const ist::Mesh& mesh, const char* up, double mass, double friction)
{
	const ZUpFile file(mesh);
	GraspReportOptions options;
	options.grasp.mesh = file.path;
	options.grasp.file = {1, ist::upAxes(up), mass};
	options.grasp.cache = TREE_FOLDER;
	options.enough = friction;
	return runGraspReport(options);
}
}  // namespace

// A can of 66 mm x 102 mm, as large as those of the YCB objects. On its side it is too wide, upright it is held, and a heavy slippery one
// is lost; each with its reason.
TEST(GraspScenarios, ACanWithZUpIsHeldOrNotWithTheReason)
{
	const ist::Mesh can = ist::makeCylinderMesh(0.033, 0.051, 64);
	const auto lying = graspOf(can, "y", 0.3, 0.5);
	ASSERT_FALSE(lying);
	EXPECT_NE(lying.error().message.find("102 mm wide along z"), std::string::npos) << lying.error().message;
	EXPECT_NE(lying.error().message.find("--up z makes it 66 mm wide there"), std::string::npos) << lying.error().message;

	const auto upright = graspOf(can, "z", 0.3, 0.5);
	ASSERT_TRUE(upright) << upright.error().message;
	EXPECT_TRUE(upright.value().rows[0].rough.held);
	EXPECT_TRUE(upright.value().ok()) << (upright.value().failures().empty() ? "" : upright.value().failures()[0]);
	EXPECT_EQ(upright.value().rows[0].mass, 0.3);

	const auto heavy = graspOf(can, "z", 5, 0.1);
	ASSERT_TRUE(heavy) << heavy.error().message;
	EXPECT_FALSE(heavy.value().rows[0].rough.held);
	ASSERT_FALSE(heavy.value().failures().empty());
	EXPECT_NE(heavy.value().failures()[0].find("it weighs 49 N"), std::string::npos) << heavy.value().failures()[0];
}

TEST(GraspScenarios, ASmallLeftHandHoldsToo)
{
	const auto scene = makeScene("nut", true, 0.172);
	ASSERT_TRUE(scene);
	const GraspOutcome outcome = runGrasp(*scene, 0.5).value();
	EXPECT_TRUE(outcome.held);
	expectSound(outcome);
}

TEST(GraspScenarios, HeatMapHoldsTheForceOfTheContacts)
{
	const auto scene = makeScene("duck");
	ASSERT_TRUE(scene);
	const auto map = scene->makeHeatMap();
	double impulse = 0;
	const GraspOutcome outcome = runGrasp(*scene, 0.5, [&] { impulse += scene->addTouches(*map) * scene->stepSize(); }).value();
	ASSERT_TRUE(outcome.held);
	double onVertices = 0, ofParts = 0, furthest = 0;
	int touched = 0;
	for (const HeatMap::Vertex& v : map->vertices())
	{
		onVertices += v.impulse;
		touched += v.part >= 0;
		if (v.dwell > 0) furthest = std::max(furthest, v.dwell);
	}
	EXPECT_NEAR(onVertices, impulse, 0.02 * impulse);
	EXPECT_GT(touched, 50);
	EXPECT_LT(furthest, GraspMotion::kEnd * 2);
	for (const HeatMap::Summary& row : map->summary())
	{
		ofParts += row.impulse;
		if (!(row.dwell > 0)) continue;
		EXPECT_NE(row.id, handPartId(kPinky1, false));
		EXPECT_LT(row.area, 1e-3);
		EXPECT_LE(row.peakForce, 1.02 * kSettings.maxForce);
	}
	EXPECT_NEAR(ofParts, impulse, 1e-6 * impulse);
	// The thumb presses against all other fingers.
	const auto rows = map->summary();
	double fingers = 0;
	for (const int part : {kIndex2, kIndex3, kMiddle2, kMiddle3, kRing2, kRing3, kPinky2, kPinky3}) fingers += rows[size_t(part)].impulse;
	EXPECT_NEAR(rows[kThumb1].impulse + rows[kThumb2].impulse + rows[kThumb3].impulse, fingers, 0.15 * fingers);
}

TEST(GraspScenarios, AHandThatIsLostInTheAirLetsGoAndSaysSo)
{
	const auto scene = makeScene("nut");
	ASSERT_TRUE(scene);
	ASSERT_FALSE(scene->start(0.5));
	bool heldOn = false;
	double height = 0;
	while (scene->time() < GraspMotion::kLifted) scene->step();
	height = double(scene->body().getWorldTransform().getOrigin().y());
	EXPECT_GT(height, 0.1);
	for (int i = 0; i < 500; ++i)
	{
		scene->step(HandState{});
		const BulletHand::Touch touch = scene->hand().touch(scene->stepSize());
		for (const Vec3& force : touch.force) ASSERT_LE(norm(force), 1.02 * kSettings.maxForce);
		// The coupling holds on for a while, in case the hand comes back.
		if (i == 100) heldOn = double(scene->body().getWorldTransform().getOrigin().y()) > height - 0.005;
	}
	EXPECT_TRUE(heldOn);
	EXPECT_LT(double(scene->body().getWorldTransform().getOrigin().y()), 0.05);
	EXPECT_NE(scene->hand().trackingMonitor().complaints().sentence().find("tracking was lost"), std::string::npos);
}

TEST(GraspScenarios, ARecordedHandHoldsLikeTheLiveOneToTheLastBit)
{
	const auto scene = makeScene("nut");
	ASSERT_TRUE(scene);
	HandMotion recorded;
	const auto run = [&](const std::function<HandState(double)>& hand) {
		EXPECT_FALSE(scene->start(0.5));
		while (scene->time() < GraspMotion::kLifted) scene->step(hand(scene->time() + scene->stepSize()));
		return toPose(scene->body().getWorldTransform());
	};
	const ist::Pose live = run([&](double time) {
		recorded.frames.push_back({time, posedHand(scene->motion().at(time), scene->motion().size)});
		return recorded.frames.back().hand;
	});
	EXPECT_GT(live.translation.y, 0.1);
	const auto read = readHandMotion(handMotionText(recorded), "recorded");
	ASSERT_TRUE(read) << read.error().message;
	const ist::Pose replayed = run([&](double time) { return read.value().at(time); });
	EXPECT_EQ(std::memcmp(&live, &replayed, sizeof live), 0);
}

// The map does a part in each step, and must sum up to the same impulse over the same time.
TEST(GraspScenarios, AMapInRoundsHoldsTheImpulseOfTheContactsToo)
{
	const auto scene = makeScene("mug");
	ASSERT_TRUE(scene);
	const auto whole = scene->makeHeatMap(), map = scene->makeHeatMap();
	BulletHeatMapRounds rounds(*map, 100);
	double impulse = 0, begun = 0, longest = 0;
	int round = 0;
	while (scene->time() < GraspMotion::kLifted)
	{
		scene->step();
		impulse += scene->addTouches(*whole) * scene->stepSize();
		scene->addTouches(rounds);
		if (rounds.rounds() != round) longest = std::max(longest, scene->time() - begun), begun = scene->time();
		round = rounds.rounds();
	}
	rounds.finish();
	EXPECT_GT(longest, 3 * scene->stepSize()) << "it takes several steps";
	EXPECT_LT(longest, 0.1);
	EXPECT_NEAR(rounds.seconds(), begun, 1e-9);
	double onVertices = 0, dwell = 0, dwellOfWhole = 0;
	for (const HeatMap::Vertex& v : map->vertices()) onVertices += v.impulse;
	for (const HeatMap::Summary& row : map->summary()) dwell += row.dwell;
	for (const HeatMap::Summary& row : whole->summary()) dwellOfWhole += row.dwell;
	EXPECT_NEAR(onVertices, rounds.impulse(), 1e-6 * impulse);
	EXPECT_NEAR(rounds.impulse(), impulse, 0.02 * impulse);
	EXPECT_NEAR(dwell, dwellOfWhole, 0.03 * dwellOfWhole);
}

TEST(GraspScenarios, TheTextureHoldsTheImpulseOfTheContacts)
{
	const auto scene = makeScene("mug");
	ASSERT_TRUE(scene);
	const auto map = scene->makeHeatMap();
	double impulse = 0;
	while (scene->time() < GraspMotion::kLifted)
	{
		scene->step();
		impulse += scene->addTouches(*map) * scene->stepSize();
	}
	const ist::TexturedMesh& surface = scene->object().texture;
	const auto texture = HeatMapTexture::make(map->mesh(), surface);
	ASSERT_TRUE(texture) << texture.error().message;
	const auto values = texture.value().values(*map, HeatMapValue::Impulse);
	ASSERT_TRUE(values) << values.error().message;
	double painted = 0;
	for (size_t i = 0; i < values.value().size(); ++i) painted += values.value()[i] * texture.value().areas()[i];
	EXPECT_GT(impulse, 1);
	EXPECT_NEAR(painted, impulse, 0.02 * impulse);

	// Other programs can read the files: the mesh has texture coordinates, and the picture has the colours of thumb and index finger.
	const std::string folder = (std::filesystem::temp_directory_path() / ("textures" + std::to_string(std::random_device()()))).string();
	std::filesystem::create_directory(folder);
	const auto scales = saveTextures(*map, surface, folder + "/mug");
	ASSERT_TRUE(scales) << scales.error().message;
	const auto read = ist::importTexturedMesh(folder + "/mug.obj");
	ASSERT_TRUE(read) << read.error().message;
	ASSERT_EQ(read.value().places.size(), surface.places.size());
	for (size_t t = 0; t < surface.places.size(); t += 97) EXPECT_NEAR(read.value().places[t][1].u, surface.places[t][1].u, 1e-5);
	const auto picture = loadPicture(folder + "/mug.png");
	ASSERT_TRUE(picture) << picture.error().message;
	const auto painting = texture.value().colours(*map);
	ASSERT_TRUE(painting) << painting.error().message;
	EXPECT_EQ(picture.value().pixels, painting.value().pixels);
	for (const int part : {kThumb3, kIndex3})
	{
		const HeatMapColour c = handPartColour(handPartId(part, false));
		int texels = 0;
		for (size_t i = 0; i < picture.value().pixels.size(); i += 3)
			texels += picture.value().pixels[i] == c.r && picture.value().pixels[i + 1] == c.g && picture.value().pixels[i + 2] == c.b;
		EXPECT_GT(texels, 100) << part;
	}
	const auto grey = loadGreyPicture(folder + "/mug-impulse.png");
	ASSERT_TRUE(grey);
	double fromPicture = 0;
	for (size_t i = 0; i < values.value().size(); ++i)
		fromPicture += grey.value().pixels[i] / 65535.0 * scales.value().impulse * texture.value().areas()[i];
	EXPECT_NEAR(fromPicture, painted, 1e-3 * painted);
	EXPECT_FALSE(saveTextures(*map, {surface.mesh, {}}, folder + "/none"));
	std::filesystem::remove_all(folder);
}

TEST(GraspScenarios, UnknownObjectsAreRefusedByName)
{
	GraspOptions options;
	options.object = "cloud";
	const auto scene = GraspScene::make(options);
	ASSERT_FALSE(scene);
	EXPECT_NE(scene.error().message.find("mug, bunny, duck"), std::string::npos);
}

TEST(GraspLoad, CountsOnlyTicksWithContactAndSaysWhatTheyCost)
{
	GraspLoadOptions options;
	options.light = true;
	options.grasp.object = "duck";
	options.grasp.cache = TREE_FOLDER;
	const auto outcome = runGraspLoad(options);
	ASSERT_TRUE(outcome) << outcome.error().message;
	// There are three skins. Each runs with the leaves, with Verlet lists, with an accepted error, with both, and with a larger error.
	ASSERT_EQ(outcome.value().loads.size(), 15u);
	const GraspLoad &firm = outcome.value().loads[0], &middle = outcome.value().loads[5], &soft = outcome.value().loads[10];
	// The contact lasts from closing to shaking, at 500 Hz.
	EXPECT_GT(firm.ticks.size(), 1200u);
	EXPECT_LT(firm.ticks.size(), 1700u);
	for (const GraspLoadTick& tick : firm.ticks) ASSERT_GT(tick.pairs, 0);
	EXPECT_GE(firm.mostParts(), 5);
	EXPECT_LE(firm.mostParts(), kHandParts);
	EXPECT_GT(soft.mostPairs(), 2 * firm.mostPairs());
	EXPECT_GT(soft.mostPairs(), middle.mostPairs());
	EXPECT_GT(middle.mostPairs(), firm.mostPairs());
	EXPECT_LE(firm.quantileMicroseconds(0.5), firm.quantileMicroseconds(0.99));
	for (const GraspLoad& load : outcome.value().loads)
	{
		EXPECT_EQ(load.errors.empty(), load.accepted == 0 && !load.remembers) << load.name;
		EXPECT_GT(load.mapSeconds, 0) << load.name;
		EXPECT_LT(load.mapSeconds, 0.3) << load.name;
		if (load.remembers && load.accepted == 0)
		{
			EXPECT_LT(load.quantileError(1, &GraspLoadError::found), 1e-4) << load.name;
		}
		for (const GraspLoadTick& tick : load.ticks)
		{
			ASSERT_GE(tick.twoMicroseconds, tick.oneMicroseconds - 0.5001 * tick.queryMicroseconds);
			ASSERT_LE(tick.twoMicroseconds, tick.oneMicroseconds);
		}
		if (load.accepted == 0) continue;
		EXPECT_LE(load.quantileError(0.95, &GraspLoadError::found), load.quantileError(0.95, &GraspLoadError::promised)) << load.name;
	}
	EXPECT_NE(makeJson(outcome.value()).find("\"most_pairs\""), std::string::npos);
	EXPECT_TRUE(outcome.value().ok());
}

TEST(GraspLoad, IsBadWithoutContactOrWithoutHold)
{
	GraspLoadOutcome outcome;
	EXPECT_FALSE(outcome.ok());
	outcome.loads.resize(2);
	for (GraspLoad& load : outcome.loads) load.ticks.resize(1);
	EXPECT_FALSE(outcome.ok());
	outcome.loads[0].held = true;
	EXPECT_TRUE(outcome.ok());
	EXPECT_NE(makeJson(outcome).find("\"ok\":true"), std::string::npos);
	outcome.loads[1].ticks.clear();
	EXPECT_FALSE(outcome.ok());
	EXPECT_NE(makeJson(outcome).find("\"ok\":false"), std::string::npos);
}

TEST(GraspReport, IsBadAsSoonAsOneGraspIs)
{
	GraspReportOutcome outcome;
	EXPECT_FALSE(outcome.ok());
	outcome.strongestAllowed = 12;
	outcome.palmAllowed = 60;
	GraspReportOutcome::Row good;
	good.rough.touched = good.rough.held = good.rough.putDown = good.rough.quality.forceClosure = true;
	good.rough.peakForce = good.smooth.peakForce = 11;
	good.rough.palmForce = 30;  // more than a bone may, and less than the palm may
	good.mapForce = 0.99;
	outcome.rows = {good};
	EXPECT_TRUE(outcome.ok());
	good.rough.friction = 0.5;
	good.rough.gripForce = 8;
	good.mass = 1;
	const char* const sentences[] = {"not lifted, 3 mm above its start, where more than 20 mm are asked: the parts pressed with 8 N in "
									 "all, of which friction bears 4 N, "
									 "and it weighs 9.8 N",
		"held, though friction", "a bone was pressed with 12.5 N, 4.2 % more than the 12 N of its coupling; 2 % are allowed",
		"the map has 103 % of the contacts' impulse", "no force closure",
		"the palm was pressed with 90 N, 50 % more than the 60 N of its coupling", "touched nothing", "lost at 2.5 s",
		"to rest on the table", "not lifted, 110 mm below its start"};
	for (int wrong = 0; wrong < 10; ++wrong)
	{
		GraspReportOutcome::Row row = good;
		if (wrong == 0) row.rough.held = false, row.rough.lostAt = 1.7, row.rough.lostHeight = 0.003;
		if (wrong == 5) row.rough.palmForce = 90;
		if (wrong == 6) row.rough.held = row.rough.touched = false, row.mapForce = 0;
		if (wrong == 7) row.rough.held = false, row.rough.lostAt = 2.5;
		if (wrong == 8) row.rough.putDown = false;
		if (wrong == 9) row.rough.held = false, row.rough.lostAt = 1.7, row.rough.lostHeight = -0.11;
		if (wrong == 1) row.smooth.held = true;
		if (wrong == 2) row.smooth.peakForce = 12.5;
		if (wrong == 3) row.mapForce = 1.03;
		if (wrong == 4) row.rough.quality.forceClosure = false;
		outcome.rows = {good, row};
		EXPECT_FALSE(outcome.ok()) << wrong;
		ASSERT_EQ(outcome.failures().size(), 1u) << wrong;
		EXPECT_NE(outcome.failures()[0].find(sentences[wrong]), std::string::npos) << outcome.failures()[0];
		EXPECT_NE(makeJson(outcome).find(sentences[wrong]), std::string::npos) << wrong;
	}
}
