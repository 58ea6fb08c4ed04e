// SPDX-License-Identifier: Zlib
#include "demos/scenes/HapticBunny.h"

#include "BulletISTCollision/Core/MeshImport.h"
#include "BulletISTCollision/Core/MeshRepair.h"
#include "BulletISTCollision/Core/MeshShapes.h"
#include "BulletISTCollision/Core/PressureField.h"
#include "DeviceBridge/BulletContactSource.h"
#include "DeviceBridge/SteppingThread.h"
#include "demos/scenes/AssetCache.h"
#include "demos/scenes/BodiesOnPlane.h"
#include "demos/scenes/HapticBunnyJudge.h"
#include "demos/scenes/MeshBelowPlane.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <utility>

using namespace ist;
using namespace devicebridge;

namespace scenes
{
namespace
{
constexpr double kTick = 1e-3;           // [s]
constexpr double kSettling = 2;          // [s]
constexpr double kLongestSide = 0.2;     // [m]
constexpr int64_t kProbeSpheres = 4000;
constexpr double kPressBack = 4, kPressEar = 1.5;  // [N]

// A cylinder of length L pressed on a flat overlaps it by about V = 4/3 sqrt(2 r) L d^1.5 at depth d: 0.4 ml for this rod at 1.8 mm. At
// 8e6 Pa/m for the pair that is the 3 N of a firm touch, and at a depth of three mean gaps the trees are at home. dF/dd = 1.5 F/d =
// 3 kN/m stays below the 4 kN/m of the coupling, so the hand feels the body rather than the coupling. The floor is softer, a
// rubber mat: the body sinks visibly under its own weight.
constexpr BodyMaterial kBodyMaterial{500, 1.6e7, 0.8};
constexpr BodyMaterial kProbeMaterial{7800, 1.6e7, 0.4};
constexpr BodyMaterial kFloorMaterial{0, 2e6, 0.8};

Result<Mesh> sourceMesh(const HapticBunnyOptions& options, double& unit)
{
	Result<Mesh> read = options.mesh.empty() ? Result<Mesh>(options.given) : importMesh(options.mesh);
	if (!read) return read.error();
	Mesh mesh = std::move(read).value();
	unit = options.unit > 0 ? options.unit : options.mesh.empty() ? 1 : kLongestSide / bounds(mesh).longestSide();
	for (Vec3& p : mesh.vertices) p *= unit;
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

/// Writes one sample per tick into memory that was there before.
class TraceRecorder
{
public:
	TraceRecorder(BodiesOnPlane& scene, const btRigidBody& body, const btRigidBody& tool, Clock& clock, SteppingThread& thread, size_t ticks)
		: m_scene(scene), m_body(body), m_tool(tool), m_clock(clock), m_thread(thread), m_capacity(ticks)
	{
		m_trace.reserve(ticks);
		thread.onTransform.addDelegate([this](const DeviceState&) { beforeStep(); });
		thread.onHapticTick.addDelegate([this](const DeviceState&, const Wrench&) { afterStep(); });
	}

	size_t size() const { return m_count.load(std::memory_order_acquire); }
	uint64_t droppedContacts() const { return m_dropped; }
	std::vector<TraceSample> take()
	{
		if (!m_trace.empty()) m_trace.back().hand = m_thread.sentWrench();
		return std::move(m_trace);
	}

private:
	void beforeStep()
	{
		// Only now is it known what the tick before sent.
		if (!m_trace.empty() && !full()) m_trace.back().hand = m_thread.sentWrench();
		const std::int64_t now = m_clock.now();
		if (m_first < 0) m_first = m_last = now;
		m_next = {};
		m_next.time = 1e-9 * static_cast<double>(now - m_first);
		m_next.period = 1e-9 * static_cast<double>(now - m_last);
		m_next.body = poseOf(m_body);
		m_next.tool = poseOf(m_tool);
		m_last = now;
	}

	void afterStep()
	{
		if (full()) return;
		const ToolStep& step = m_thread.step();
		m_next.pairs = step.pairs;
		m_next.queryMicroseconds = step.queryMicroseconds;
		if (const btISTContact* contact = m_scene.contactBetween(m_body, m_tool))
		{
			const btISTPairConstants& c = contact->constants;
			const double sign = contact->bodyA == &m_tool ? 1 : -1;
			m_next.elastic = sign * (contact->X_WA.rotation * pressureWrench(contact->total, {c.k, c.weightA, c.weightB}).force);
			m_next.volume = contact->total.volume;
			m_next.volumeSigma = contact->error.volume;
			m_next.forceSigma = contact->error.force;
		}
		for (const btISTContact* contact : m_scene.world().contacts().contacts()) m_dropped += contact->status != QueryStatus::Ok;
		m_trace.push_back(m_next);
		m_count.store(m_trace.size(), std::memory_order_release);
	}
	bool full() const { return m_trace.size() == m_capacity; }

	BodiesOnPlane& m_scene;
	const btRigidBody &m_body, &m_tool;
	Clock& m_clock;
	SteppingThread& m_thread;
	size_t m_capacity;
	std::vector<TraceSample> m_trace;
	TraceSample m_next;
	std::atomic<size_t> m_count{0};
	std::int64_t m_first = -1, m_last = -1;
	uint64_t m_dropped = 0;
};

bool report(const HapticBunnyOptions& options, const char* stage, double fraction)
{
	return !options.progress || options.progress(stage, fraction);
}

/// False when the caller cancelled.
bool perform(SteppingThread& thread, const TraceRecorder& recorder, size_t ticks, const HapticBunnyOptions& options)
{
	const auto fraction = [&] { return static_cast<double>(recorder.size()) / static_cast<double>(ticks); };
	if (options.virtualTime)
	{
		while (recorder.size() < ticks)
		{
			thread.run(static_cast<std::int64_t>(std::min<size_t>(250, ticks - recorder.size())));
			if (!report(options, "hand", fraction())) return false;
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

/// The hand's whole session, on a body that stands.
bool playHand(BodiesOnPlane& scene, const btRigidBody& body, btRigidBody& tool, const ProbePath& path, const HapticBunnyOptions& options,
			  HapticBunnyOutcome& outcome)
{
	const SimulatedProfile profile = handProfile();
	// The middle of the device's workspace lies where the path begins.
	Pose X_BW;
	X_BW.translation = path.frames.front().pose.translation;
	std::vector<HandKeyFrame> frames = path.frames;
	for (HandKeyFrame& frame : frames) frame.pose = inverse(X_BW) * frame.pose;
	SimulatedDevice device(profile);
	device.place(frames.front().pose);
	device.setHand(handThrough(std::move(frames)));
	device.open();

	BulletToolSettings settings;
	settings.gains = passiveGains(profile.info, profile.damping, profile.angularDamping, kTick);
	settings.X_BW = X_BW;
	BulletContactSource source(scene.world(), tool, settings);
	const std::unique_ptr<Clock> clock =
		options.virtualTime ? std::unique_ptr<Clock>(std::make_unique<VirtualClock>()) : std::make_unique<RealClock>();
	SteppingThread thread(device, source, *clock);
	const size_t ticks = static_cast<size_t>(path.duration / kTick);
	TraceRecorder recorder(scene, body, tool, *clock, thread, ticks);
	const bool done = perform(thread, recorder, ticks, options);
	outcome.trace = recorder.take();
	outcome.droppedContacts = recorder.droppedContacts();
	outcome.overruns = thread.overruns();
	outcome.deviceErrors = thread.deviceErrors();
	outcome.scheduling = options.virtualTime ? "virtual time, on the caller's thread" : thread.scheduling();
	outcome.safety = thread.safetyCounts();
	outcome.faulted = thread.faulted();
	outcome.work = device.work();
	return done;
}

/// Stands it on the plane, upright as its file has it, and waits until it rests.
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
	const Result<btRigidBody*> tool =
		scene.add(probe.value().principal.mesh, probe.value().cached.tree, kProbeMaterial, path.frames.front().pose);
	if (!tool) return tool.error();
	if (!playHand(scene, *standing.value(), *tool.value(), path, options, outcome)) return Error{"the run was stopped", true};

	const double kBody = kBodyMaterial.stiffness, kProbe = kProbeMaterial.stiffness;
	outcome.pairStiffness = kBody * kProbe / (kBody + kProbe);
	judgeTrace(body.value().principal.mesh, probe.value().principal.mesh, kProbe / (kBody + kProbe), options, outcome);
	summarise(outcome);
	return outcome;
}
}  // namespace scenes
