// SPDX-License-Identifier: Zlib
#include "demos/scenes/HapticBunny/HapticBunny.h"

#include "BulletISTCollision/Core/Force/PressureField.h"
#include "BulletISTCollision/Core/Import/MeshImport.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "BulletISTCollision/Core/Repair/MeshRepair.h"
#include "DeviceBridge/Bullet/BulletContactSource.h"
#include "DeviceBridge/Bullet/BulletWorldCoupling.h"
#include "DeviceBridge/Loop/SteppingThread.h"
#include "TestSupport/SceneFiles/AssetCache.h"
#include "TestSupport/SceneFiles/PrincipalMesh.h"
#include "demos/scenes/Bodies/BodiesOnPlane.h"
#include "demos/scenes/HapticBunny/HapticBunnyJudge.h"
#include "demos/scenes/Truth/MeshBelowPlane.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

using namespace ist;
using namespace devicebridge;

namespace scenes
{
namespace
{
constexpr double kTick = 1e-3;        // [s]
constexpr double kSettling = 2;       // [s]
constexpr double kLongestSide = 0.2;  // [m]
constexpr int64_t kProbeSpheres = 4000;
constexpr double kPressBack = 4, kPressEar = 1.5;  // [N]

// A cylinder of length L pressed on a flat surface overlaps it by about V = 4/3 sqrt(2 r) L d^1.5 at depth d. For this rod that is 0.4 ml
// at 1.8 mm. At 8e6 Pa/m for the pair this gives 3 N, a firm touch. The depth is three mean gaps, at which the trees are accurate. dF/dd
// = 1.5 F/d = 3 kN/m is below the 4 kN/m of the coupling, so the hand feels the body rather than the coupling. The floor is softer, like
// a rubber mat: the body visibly sinks under its own weight.
constexpr BodyMaterial kBodyMaterial{500, 1.6e7, 0.8};
constexpr BodyMaterial kProbeMaterial{7800, 1.6e7, 0.4};
constexpr BodyMaterial kFloorMaterial{0, 2e6, 0.8};

Result<Mesh> sourceMesh(const HapticBunnyOptions& options, double& unit)
{
	const std::optional<double> stated = options.unit > 0 ? std::optional(options.unit) : std::nullopt;
	Result<Mesh> read = options.mesh.empty() ? Result<Mesh>(options.given) : importMesh(options.mesh, stated);
	if (!read) return read.error();
	Mesh mesh = turnedUp(std::move(read).value(), options.up);
	const double scale = options.mesh.empty() ? stated.value_or(1) : stated ? 1 : kLongestSide / bounds(mesh).longestSide();
	for (Vec3& p : mesh.vertices) p *= scale;
	unit = scale * mesh.unit;
	if (options.say)
		for (const std::string& sentence : mesh.notTaken) options.say(sentence);
	return mesh;
}

struct Body
{
	PrincipalMesh principal;
	CachedTree cached;
};

Result<Body> makeBody(const Mesh& mesh, int64_t spheres, double unit, const char* name, const HapticBunnyOptions& options)
{
	BuildOptions build;
	build.maxSpheres = spheres;
	build.seed = options.seed;
	build.unit = unit;
	build.progress = options.progress;
	Body body;
	body.principal = inPrincipalFrame(mesh);
	Result<CachedTree> cached = treeFromCache(body.principal.mesh, build, options.cache, name, options.say);
	if (!cached) return cached.error();
	body.cached = std::move(cached).value();
	return body;
}

SimulatedProfile handProfile() { return simulatedProfile("sigma7").value(); }

/// Writes one sample per tick into preallocated memory. `poses` fills in poses before a step, and `contact` the result of the step.
class TraceRecorder
{
public:
	using Fill = std::function<void(TraceSample&)>;
	TraceRecorder(Clock& clock, SteppingThread& thread, size_t ticks, Fill poses, Fill contact)
		: m_clock(clock),
		  m_thread(thread),
		  m_capacity(ticks),
		  m_poses(std::move(poses)),
		  m_contact(std::move(contact))
	{
		m_trace.reserve(ticks);
		thread.onTransform.addDelegate([this](const DeviceState&) { beforeStep(); });
		thread.onHapticTick.addDelegate([this](const DeviceState&, const Wrench&) { afterStep(); });
	}

	size_t size() const { return m_count.load(std::memory_order_acquire); }
	std::vector<TraceSample> take()
	{
		if (!m_trace.empty()) m_trace.back().hand = m_thread.sentWrench();
		return std::move(m_trace);
	}

private:
	void beforeStep()
	{
		// The wrench that the tick before has sent is known only now.
		if (!m_trace.empty() && !full()) m_trace.back().hand = m_thread.sentWrench();
		const std::int64_t now = m_clock.now();
		if (m_first < 0) m_first = m_last = now;
		m_next = {};
		m_next.time = 1e-9 * static_cast<double>(now - m_first);
		m_next.period = 1e-9 * static_cast<double>(now - m_last);
		m_poses(m_next);
		m_last = now;
	}

	void afterStep()
	{
		if (full()) return;
		const ToolStep& step = m_thread.step();
		m_next.pairs = step.pairs;
		m_next.queryMicroseconds = step.queryMicroseconds;
		m_contact(m_next);
		m_trace.push_back(m_next);
		m_count.store(m_trace.size(), std::memory_order_release);
	}
	bool full() const { return m_trace.size() == m_capacity; }

	Clock& m_clock;
	SteppingThread& m_thread;
	size_t m_capacity;
	Fill m_poses, m_contact;
	std::vector<TraceSample> m_trace;
	TraceSample m_next;
	std::atomic<size_t> m_count{0};
	std::int64_t m_first = -1, m_last = -1;
};

/// Fills in what simple mode knows about rod and body.
void fillFromStore(BodiesOnPlane& scene, const btRigidBody& body, const btRigidBody& tool, TraceSample& sample, uint64_t& dropped)
{
	if (const btISTContact* contact = scene.contactBetween(body, tool))
	{
		const btISTPairConstants& c = contact->constants;
		const double sign = contact->bodyA == &tool ? 1 : -1;
		sample.elastic = sign * (contact->X_WA.rotation * pressureWrench(contact->total, {c.k, c.weightA, c.weightB}).force);
		sample.volume = contact->total.volume;
		sample.volumeSigma = contact->error.volume;
		sample.forceSigma = contact->error.force;
	}
	for (const btISTContact* contact : scene.world().contacts().contacts()) dropped += contact->status != QueryStatus::Ok;
}

/// Fills in what the hand's thread knows about rod and body in decoupled mode; poses are in World.
void fillFromSource(const BulletDecoupledSource& source, const btRigidBody& body, double volume, TraceSample& sample)
{
	sample.volume = volume;
	for (int i = 0; i < source.touchingCount(); ++i)
	{
		const LinearContact& contact = source.touching(i);
		if (source.touched(i) == &body) sample.elastic += contact.wrench.force;
	}
}

bool report(const HapticBunnyOptions& options, const char* stage, double fraction)
{
	return !options.progress || options.progress(stage, fraction);
}

/// Runs all ticks. Returns false when the caller has cancelled. In virtual time, `between` runs before each tick.
bool perform(SteppingThread& thread, const TraceRecorder& recorder, size_t ticks, const HapticBunnyOptions& options,
	const std::function<void()>& between)
{
	const auto fraction = [&] { return static_cast<double>(recorder.size()) / static_cast<double>(ticks); };
	if (options.virtualTime)
	{
		while (recorder.size() < ticks)
		{
			between();
			if (!thread.run(1)) return false;
			if (recorder.size() % 250 == 0 && !report(options, "hand", fraction())) return false;
		}
		return true;
	}
	if (!thread.start()) return false;
	bool wanted = true;
	while (wanted && recorder.size() < ticks)
	{
		std::this_thread::sleep_for(std::chrono::milliseconds(100));
		wanted = report(options, "hand", fraction());
	}
	thread.stop();
	return wanted;
}

/// A hand on its device, and the clock of both.
struct HandSetup
{
	SimulatedProfile profile = handProfile();
	SimulatedDevice device{profile};
	std::unique_ptr<Clock> clock;
	Pose X_BW;  ///< the middle of the device's workspace is the start of the path
	CouplingGains gains = passiveGains(profile.info, profile.damping, profile.angularDamping, kTick);
	size_t ticks;

	HandSetup(const ProbePath& path, bool virtualTime) : ticks(static_cast<size_t>(path.duration / kTick))
	{
		if (virtualTime) clock = std::make_unique<VirtualClock>();
		else clock = std::make_unique<RealClock>();
		X_BW.translation = path.frames.front().pose.translation;
		std::vector<HandKeyFrame> frames = path.frames;
		for (HandKeyFrame& frame : frames) frame.pose = inverse(X_BW) * frame.pose;
		device.place(frames.front().pose);
		device.setHand(handThrough(std::move(frames)));
		device.open();
	}
};

void keepFigures(const HandSetup& hand, const SteppingThread& thread, TraceRecorder& recorder, HapticBunnyOutcome& outcome)
{
	outcome.trace = recorder.take();
	outcome.overruns = thread.overruns();
	outcome.deviceErrors = thread.deviceErrors();
	outcome.scheduling = outcome.virtualTime ? "virtual time, on the caller's thread" : thread.scheduling();
	outcome.memory = thread.memory();
	outcome.safety = thread.safetyCounts();
	outcome.faulted = thread.faulted();
	outcome.work = hand.device.work();
}

/// Memory is locked, because the hand is the purpose of this program.
SteppingSettings sessionSettings()
{
	SteppingSettings settings;
	settings.lockMemory = true;
	return settings;
}

/// Runs the hand's whole path on a standing body in simple mode.
bool playHand(BodiesOnPlane& scene, const btRigidBody& body, btRigidBody& tool, const ProbePath& path, const HapticBunnyOptions& options,
	HapticBunnyOutcome& outcome)
{
	HandSetup hand(path, options.virtualTime);
	BulletToolSettings settings;
	settings.gains = hand.gains;
	settings.X_BW = hand.X_BW;
	BulletContactSource source(scene.world(), tool, settings);
	SteppingThread thread(hand.device, source, *hand.clock, sessionSettings());
	TraceRecorder recorder(
		*hand.clock, thread, hand.ticks, [&](TraceSample& sample) { sample.body = poseOf(body), sample.tool = poseOf(tool); },
		[&](TraceSample& sample) { fillFromStore(scene, body, tool, sample, outcome.droppedContacts); });
	const bool done = perform(thread, recorder, hand.ticks, options, [] {});
	keepFigures(hand, thread, recorder, outcome);
	return done;
}

/// Runs the hand's whole path with a world that steps at its own rate.
bool playDecoupled(BodiesOnPlane& scene, const btRigidBody& body, const Body& probe, btRigidBody& tool, const ProbePath& path,
	const HapticBunnyOptions& options, HapticBunnyOutcome& outcome)
{
	HandSetup hand(path, options.virtualTime);
	BulletDecoupledSettings settings;
	settings.gains = hand.gains;
	settings.X_BW = hand.X_BW;
	scene.world().bullet().removeRigidBody(&tool);
	BulletDecoupledSource source(tool, probe.cached.tree, *hand.clock, settings);
	BulletWorldCoupling coupling(scene.world());
	coupling.add(source);
	const double period = 1 / options.worldRate;
	coupling.show(period);
	SteppingThread thread(hand.device, source, *hand.clock, sessionSettings());
	TraceRecorder recorder(
		*hand.clock, thread, hand.ticks,
		[&](TraceSample& sample) {
			sample.tool = hand.X_BW * source.toolState().X_WT;
			source.copyOf(&body, sample.body);
		},
		[&](TraceSample& sample) { fillFromSource(source, body, thread.step().overlapVolume, sample); });

	const Vec3 before = poseOf(body).translation;
	const std::int64_t start = hand.clock->now();
	std::int64_t steps = 0;
	const auto due = [&] { return start + static_cast<std::int64_t>(1e9 * period * static_cast<double>(steps + 1)); };
	std::atomic<bool> running{true};
	std::thread world;
	if (!options.virtualTime)
		world = std::thread([&] {
			for (; running; ++steps)
			{
				hand.clock->sleepUntil(due());
				coupling.step(period);
			}
		});
	const bool done = perform(thread, recorder, hand.ticks, options, [&] {
		for (; due() <= hand.clock->now(); ++steps) coupling.step(period);
	});
	running = false;
	if (world.joinable()) world.join();
	keepFigures(hand, thread, recorder, outcome);
	const DecoupledStatistics statistics = source.statistics();
	outcome.worldRate = options.worldRate;
	outcome.droppedContacts = statistics.refusedQueries;
	coupling.step(period);  // applies the impulses that are still under way
	outcome.decoupled = {statistics.worldSteps, statistics.fadedTicks, statistics.longestModelAge, source.receivedImpulse(),
		coupling.appliedImpulse(source), {}, distance(poseOf(body).translation, before)};
	outcome.decoupled.underWay = -(outcome.decoupled.toTool + outcome.decoupled.toWorld);
	return done;
}

/// Puts the body on the plane, upright as in its file, and waits until it rests.
Result<btRigidBody*> standOnPlane(BodiesOnPlane& scene, const Body& body)
{
	Pose X_WB{body.principal.X_MP.rotation, {}};
	X_WB.translation.y = -lowestPoint(body.principal.mesh, X_WB);
	Result<btRigidBody*> added = scene.add(body.principal.mesh, body.cached.tree, kBodyMaterial, X_WB);
	if (added)
		for (int i = 0; i < static_cast<int>(kSettling / kTick); ++i) scene.step(kTick);
	return added;
}
}  // namespace

Result<HapticBunnyOutcome> runHapticBunny(const HapticBunnyOptions& options)
{
	HapticBunnyOutcome outcome;
	Result<Mesh> source = sourceMesh(options, outcome.unit);
	if (!source) return source.error();
	Result<RepairedMesh> repaired = repair(source.value());
	if (!repaired) return repaired.error();
	const Result<Body> body = makeBody(repaired.value().mesh, options.spheres, outcome.unit, "body", options);
	if (!body) return body.error();
	const RodProbe rod;
	const Result<Body> probe = makeBody(makeCapsuleMesh(rod.radius, rod.halfLength), kProbeSpheres, 1, "rod", options);
	if (!probe) return probe.error();

	const InnerSphereTree& tree = *body.value().cached.tree;
	outcome.mesh = options.mesh;
	outcome.triangles = repaired.value().mesh.triangles.size();
	outcome.repair = repaired.value().actions;
	outcome.spheres = tree.spheres.size();
	outcome.leaves = tree.law.ballCount();
	outcome.fill = tree.fill;
	outcome.mass = kBodyMaterial.density * tree.volume;
	outcome.buildSeconds = body.value().cached.seconds;
	outcome.loadedFromCache = body.value().cached.loaded;
	outcome.virtualTime = options.virtualTime;

	report(options, "settling", 0);
	BodiesOnPlane scene(kFloorMaterial);
	const Result<btRigidBody*> standing = standOnPlane(scene, body.value());
	if (!standing) return standing.error();
	const Pose X_WB = poseOf(*standing.value());
	const double floorStiffness = 1 / (1 / kBodyMaterial.stiffness + 1 / kFloorMaterial.stiffness);
	outcome.sinkage = judgeSinkage(tree, body.value().principal.mesh, X_WB, outcome.mass * 9.81 / floorStiffness);

	const double spring = handProfile().handStiffness;
	const MeshDistance surface(transformed(body.value().principal.mesh, X_WB));
	ProbePath path = makeProbePath(surface, rod, {kPressBack / spring, kPressEar / spring});
	outcome.phases = path.phases;
	for (HandKeyFrame& frame : path.frames) frame.pose = frame.pose * probe.value().principal.X_MP;
	const Result<btRigidBody*> tool = scene.add(
		probe.value().principal.mesh, probe.value().cached.tree, kProbeMaterial, path.frames.front().pose);
	if (!tool) return tool.error();
	const bool done = options.decoupled ? playDecoupled(scene, *standing.value(), probe.value(), *tool.value(), path, options, outcome)
										: playHand(scene, *standing.value(), *tool.value(), path, options, outcome);
	if (!done) return Error{"the run was stopped", true};

	const double kBody = kBodyMaterial.stiffness, kProbe = kProbeMaterial.stiffness;
	outcome.pairStiffness = kBody * kProbe / (kBody + kProbe);
	judgeTrace(body.value().principal.mesh, probe.value().principal.mesh, kProbe / (kBody + kProbe), options, outcome);
	summarise(outcome);
	return outcome;
}
}  // namespace scenes
