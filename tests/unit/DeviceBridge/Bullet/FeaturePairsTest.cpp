// SPDX-License-Identifier: Zlib
// Every pair of features of a haptic loop that can be switched while it runs, against each other, in virtual time. A new feature is one
// entry of `features`, a new kind of tool one of `kTools`.
#include "DeviceBridge/Decorators/ClutchedDevice.h"
#include "DeviceBridge/Decorators/RecordingDevice.h"
#include "DeviceBridge/Drivers/Simulated/SimulatedDevice.h"
#include "DeviceBridge/Loop/SteppingThread.h"
#include "DeviceBridge/Loop/ThreadedForceLaw.h"
#include "tests/unit/DeviceBridge/Bullet/DecoupledRig.h"

#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

using namespace devicebridge;
using ist::Vec3;

namespace
{
constexpr int kApproach = 280, kOn = 40, kBoth = 120, kOne = 160, kOff = 180, kFree = 220;  // ticks of the phases of a pair
constexpr int kJudged = 20;                                                                 // last ticks of a phase
constexpr double kRate = 240, kAbove = 0.065, kPressed = 0.051;                             // [Hz, m, m]

/// Switches what a device does.
class SpiedDevice final : public DeviceDecorator
{
public:
	bool unplugged = false, frozen = false, writesRefused = false, jumped = false, notRigid = false, handAway = false, clutch = false;
	SpiedDevice(std::unique_ptr<Device> inner) : DeviceDecorator(std::move(inner)) {}
	DeviceStatus read(std::int64_t now, DeviceState& state) noexcept override
	{
		DeviceState fresh = m_sample;
		const DeviceStatus status = m_inner->read(now, fresh);
		if (unplugged) return DeviceStatus::Disconnected;
		if (!frozen) m_sample = fresh;
		state = m_sample;
		if (jumped) state.X_WH.translation.y += 0.1;
		if (notRigid) state.X_WH.rotation.m[1][1] = 3;
		if (handAway) state.flags &= ~static_cast<std::uint32_t>(kHandPresent);
		state.buttons = clutch ? 1 : 0;
		return status;
	}
	DeviceStatus write(const DeviceCommand& command) noexcept override
	{
		return unplugged || writesRefused ? DeviceStatus::Disconnected : m_inner->write(command);
	}

private:
	DeviceState m_sample;
};

struct Tool
{
	const char* name;
	double mass;
	CouplingGains gains;
	bool gravity;
};
constexpr double kToolMass = 0.03;  // [kg]
const Tool kTools[] = {{"dynamic", kToolMass, {2000, 0.4, 0, 0, 12, 0.2}, false},
	{"static", kToolMass, {2000, 0.4, 0, 0, 12, 0.2, true}, false}, {"static_without_mass", 0, {2000, 0.4, 0, 0, 12, 0.2, true}, false},
	{"adaptive", kToolMass, {1000, 0.4, 0, 0, 12, 0.2, false, 2}, false},
	{"static_adaptive", 0, {1000, 0.4, 0, 0, 12, 0.2, true, 2}, false}, {"with_weight", 0.01, {2000, 0.4, 0, 0, 12, 0.2}, true}};

btConvexHullShape boxHull()
{
	btConvexHullShape hull;
	for (int i = 0; i < 8; ++i) hull.addPoint(bullet(kBoxHalf * Vec3{i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0}));
	hull.setMargin(0);
	return hull;
}

/// A simulated hand presses a box on a table.
struct Loop
{
	DecoupledRig rig{kRate, {0, -9.81, 0}};
	// A box without a tree would be felt in closed form; a hull without a tree is not felt.
	btConvexHullShape shape = boxHull(), stockShape = boxHull();
	btISTAttachment attached;
	btRigidBody* box = nullptr;
	SimulatedDevice* simulated = nullptr;
	SpiedDevice* spy = nullptr;
	std::unique_ptr<Device> device;
	btRigidBody tool;
	BulletDecoupledSource source;
	CouplingForceLaw coupling;
	ThreadedForceLaw law{coupling};
	SteppingThread thread;
	std::unique_ptr<Hand> other;
	std::map<std::string, std::uint64_t> listeners;
	bool inOwnThread = false, inWorld = false;  ///< topologies that are asked for
	bool threadedLaw = false, hangingLaw = false;
	bool raises = false, inCoupling = true;
	double largest = 0, judgedLeast = 0, judgedMost = 0;  ///< force of the device, ever and in the last ticks [N]

	explicit Loop(const Tool& kind)
		: device(makeDevice()),
		  tool(toolInfo(rig.ballShape, kind.mass)),
		  source(tool, ballTree(), rig.clock, sourceSettings(kind)),
		  thread(*device, source, rig.clock, steppingSettings())
	{
		attach();
		rig.addPlane();
		box = rig.add(shape, 0.3, {0, 0.02, 0});
		if (const auto refused = rig.world.materials().set(&tool, {2e7, -1})) throw std::runtime_error(refused->message);
		rig.coupling.add(source);
		law.setThreaded(false);
		thread.setForceLaw(&law);
		ist::Pose start, pressed;
		start.translation.y = kAbove;
		pressed.translation.y = kPressed;
		simulated->place(start);
		simulated->setHand(handThrough({{0.03, start}, {0.2, pressed}}));
		device->open();
		rig.coupling.show(rig.period);
	}
	void lift()
	{
		ist::Pose now, end;
		now.translation.y = kPressed, end.translation.y = kAbove;
		simulated->setHand(handThrough({{rig.time(), now}, {rig.time() + 0.1, end}}));
	}
	/// Three decorators about the simulated hand; the recording ends in the middle.
	std::unique_ptr<Device> makeDevice()
	{
		auto hand = std::make_unique<SimulatedDevice>(simulatedProfile("sigma7").value());
		simulated = hand.get();
		auto spied = std::make_unique<SpiedDevice>(std::move(hand));
		spy = spied.get();
		return std::make_unique<RecordingDevice>(std::make_unique<ClutchedDevice>(std::move(spied), 1U), 400);
	}
	static btRigidBody::btRigidBodyConstructionInfo toolInfo(btCollisionShape& shape, double mass)
	{
		btRigidBody::btRigidBodyConstructionInfo info = Hand::info(shape, {0, kAbove, 0});
		info.m_localInertia *= btScalar(mass) / info.m_mass;
		info.m_mass = btScalar(mass);
		return info;
	}
	static BulletDecoupledSettings sourceSettings(const Tool& kind)
	{
		BulletDecoupledSettings settings = handSettings();
		settings.gains = kind.gains;
		settings.gravity = kind.gravity;
		settings.fadeIn = 0.03;
		return settings;
	}
	static SteppingSettings steppingSettings()
	{
		SteppingSettings settings;
		settings.safety.rampTime = 30'000'000;
		settings.safety.startInsideLatch = false;  // otherwise a force that was away stays away until the tool is free
		return settings;
	}
	void attach()
	{
		if (attached.isAttached()) return;
		auto tree = std::make_shared<ist::InnerSphereTree>(*boxTree());
		tree->levels.clear();
		const btVector3 scaling = shape.getLocalScaling();
		shape.setLocalScaling(btVector3(1, 1, 1));  // for which the tree was made
		attached = rig.world.attach(&shape, std::move(tree)).value();
		shape.setLocalScaling(scaling);
	}
	void chooseTopology()
	{
		source.setTopology(inOwnThread ? ContactThreading::OwnThread
				: inWorld              ? ContactThreading::InWorldThread
									   : ContactThreading::InHapticThread);
	}
	void chooseLaw() { law.setThreaded(threadedLaw || hangingLaw); }
	void putBack()
	{
		box->setWorldTransform(btTransform(btQuaternion::getIdentity(), btVector3(0, btScalar(0.02), 0)));
		box->setInterpolationWorldTransform(box->getWorldTransform());
		box->setLinearVelocity(btVector3(0, 0, 0));
		box->setAngularVelocity(btVector3(0, 0, 0));
	}
	void setPeriod(double period)
	{
		rig.period = period;
		rig.worldSteps = static_cast<std::int64_t>(rig.time() / period);
	}
	double force() const { return norm(thread.sentWrench().force); }
	void stepWorld()
	{
		while (rig.worldRuns && static_cast<double>(rig.worldSteps + 1) * rig.period <= rig.time() + 1e-9) rig.stepWorld();
	}
	void run(int ticks)
	{
		judgedLeast = std::numeric_limits<double>::infinity(), judgedMost = 0;
		for (int i = 0; i < ticks; ++i)
		{
			stepWorld();
			if (raises) thread.raiseFault();
			ASSERT_TRUE(thread.run(1)) << thread.refusal();
			if (inOwnThread) source.serveContacts();
			if (!hangingLaw) law.serve();
			if (other) other->tick(rig.time());
			largest = std::isfinite(force()) && isFinite(source.toolState().twist) ? std::max(largest, force())
																				   : std::numeric_limits<double>::quiet_NaN();
			if (i < ticks - kJudged) continue;
			judgedLeast = std::min(judgedLeast, force());
			judgedMost = std::max(judgedMost, force());
		}
	}
	/// A while without ticks.
	void gap()
	{
		thread.stop();
		EXPECT_EQ(force(), 0);
		rig.clock.sleepUntil(rig.clock.now() + 50'000'000);
	}
	template <class Act> void listen(const std::string& name, Act act)
	{
		listeners[name] = thread.onHapticTick.addDelegate([act](const DeviceState&, ist::Wrench& wrench) { act(wrench); });
	}
	void unlisten(const std::string& name)
	{
		thread.onHapticTick.removeDelegate(listeners[name]);
		thread.clearFault();
	}
};

struct Effect
{
	bool silent = false;  ///< no force
	FaultCause cause = FaultCause::None;
	double share = 0.2;        ///< by which the force may differ from what it is without
	bool atNewPlace = false;   ///< the handle is elsewhere for a while, or for good: how deep it presses is another
	bool feelsNothing = true;  ///< where it is silent, the tool's inertia is not felt either
};

struct Feature
{
	const char* name;
	Effect effect;
	std::function<void(Loop&)> on, off;
};

constexpr Effect kSilent{true}, kBodyIsGone{true, FaultCause::None, 0.2, false, false};
constexpr Effect fault(FaultCause cause) { return {true, cause}; }

/// A member of the loop, or of its device, that is true while the feature is on.
template <class Member> Feature whileOn(const char* name, const Effect& effect, Member member, void (Loop::*then)() = nullptr)
{
	const auto set = [member, then](Loop& l, bool on) {
		member(l) = on;
		if (then) (l.*then)();
	};
	return {name, effect, [set](Loop& l) { set(l, true); }, [set](Loop& l) { set(l, false); }};
}

std::vector<Feature> featuresOfDevice()
{
	const double nan = std::numeric_limits<double>::quiet_NaN();
	const auto clears = [](Feature f) {
		f.off = [off = f.off](Loop& l) { off(l), l.thread.clearFault(); };
		return f;
	};
	return {whileOn("no device", fault(FaultCause::Disconnected), [](Loop& l) -> bool& { return l.spy->unplugged; }),
		whileOn("samples that repeat", fault(FaultCause::Frozen), [](Loop& l) -> bool& { return l.spy->frozen; }),
		whileOn("writes that are refused", fault(FaultCause::Disconnected), [](Loop& l) -> bool& { return l.spy->writesRefused; }),
		whileOn("a handle that jumps", {true, FaultCause::Jump, 0.2, true, false}, [](Loop& l) -> bool& { return l.spy->jumped; }),
		clears(whileOn("a pose that is not rigid", fault(FaultCause::InvalidState), [](Loop& l) -> bool& { return l.spy->notRigid; })),
		whileOn("no hand at the handle", kSilent, [](Loop& l) -> bool& { return l.spy->handAway; }),
		whileOn("the clutch", {true, FaultCause::None, 0.2, true}, [](Loop& l) -> bool& { return l.spy->clutch; }),
		{"no forces", kSilent, [](Loop& l) { l.thread.enableForces(false); }, [](Loop& l) { l.thread.enableForces(true); }},
		clears(whileOn("a raised fault", fault(FaultCause::Raised), [](Loop& l) -> bool& { return l.raises; })),
		{"a wrench that is not finite", fault(FaultCause::NotFinite),
			[nan](Loop& l) { l.listen("nan", [nan](ist::Wrench& w) { w.torque.y = nan; }); }, [](Loop& l) { l.unlisten("nan"); }},
		{"a listener that throws", fault(FaultCause::HookException),
			[](Loop& l) { l.listen("throws", [](ist::Wrench&) { throw std::runtime_error("a listener"); }); },
			[](Loop& l) { l.unlisten("throws"); }},
		{"a gap between ticks", {}, &Loop::gap, &Loop::gap},
		whileOn(
			"a law in a thread", {}, [](Loop& l) -> bool& { return l.threadedLaw; }, &Loop::chooseLaw),
		whileOn(
			"a law that hangs", kSilent, [](Loop& l) -> bool& { return l.hangingLaw; }, &Loop::chooseLaw)};
}

std::vector<Feature> featuresOfBody()
{
	const auto setFlag = [](int flag) {
		return std::pair<std::function<void(Loop&)>, std::function<void(Loop&)>>{
			[flag](Loop& l) { l.box->setCollisionFlags(l.box->getCollisionFlags() | flag); },
			[flag](Loop& l) { l.box->setCollisionFlags(l.box->getCollisionFlags() & ~flag), l.putBack(); }};
	};
	const auto [mute, speak] = setFlag(btCollisionObject::CF_NO_CONTACT_RESPONSE);
	const auto [hold, let] = setFlag(btCollisionObject::CF_KINEMATIC_OBJECT);
	const auto setMass = [](Loop& l, double mass) {
		btVector3 inertia;
		l.shape.calculateLocalInertia(btScalar(mass), inertia);
		l.box->setMassProps(btScalar(mass), inertia);
		l.box->updateInertiaTensor();
	};
	return {
		{"a body that is removed", kBodyIsGone, [](Loop& l) { l.rig.coupling.forget(l.box), l.rig.world.bullet().removeRigidBody(l.box); },
			[](Loop& l) {
				l.putBack();
				l.rig.world.bullet().addRigidBody(l.box, btBroadphaseProxy::DefaultFilter, btBroadphaseProxy::AllFilter);
			}},
		{"a tree that is detached", kBodyIsGone, [](Loop& l) { l.attached.detach(); }, [](Loop& l) { l.attach(), l.putBack(); }},
		{"another shape", kBodyIsGone, [](Loop& l) { l.box->setCollisionShape(&l.stockShape); },
			[](Loop& l) { l.box->setCollisionShape(&l.shape), l.putBack(); }},
		{"a scaled shape", kBodyIsGone, [](Loop& l) { l.shape.setLocalScaling(btVector3(1, 1, btScalar(1.1))); },
			[](Loop& l) { l.shape.setLocalScaling(btVector3(1, 1, 1)), l.putBack(); }},
		{"no contact response", kBodyIsGone, mute, speak}, {"a kinematic body", {}, hold, let},
		{"a sleeping body", {}, [](Loop& l) { l.box->forceActivationState(ISLAND_SLEEPING); },
			[](Loop& l) { l.box->forceActivationState(DISABLE_DEACTIVATION); }},
		{"a heavier body", {}, [setMass](Loop& l) { setMass(l, 1); }, [setMass](Loop& l) { setMass(l, 0.3); }},
		{"a softer body", {false, FaultCause::None, 0.3},
			[](Loop& l) {
				(void)l.rig.world.materials().set(l.box, {5e6, -1});
			},
			[](Loop& l) {
				(void)l.rig.world.materials().set(l.box, {2e7, -1});
			}}};
}

std::vector<Feature> featuresOfWorld()
{
	const btVector3 far(100, 100, 100);
	return {whileOn(
				"contacts in a thread", {}, [](Loop& l) -> bool& { return l.inOwnThread; }, &Loop::chooseTopology),
		whileOn(
			"contacts in the world", {}, [](Loop& l) -> bool& { return l.inWorld; }, &Loop::chooseTopology),
		{"a world that does not step", kSilent, [](Loop& l) { l.rig.worldRuns = false; },
			[](Loop& l) { l.rig.worldRuns = true, l.setPeriod(l.rig.period); }},
		{"a slower world", {}, [](Loop& l) { l.setPeriod(1.0 / 60); }, [](Loop& l) { l.setPeriod(1 / kRate); }},
		{"no gravity", {}, [](Loop& l) { l.rig.world.setGravity(btVector3(0, 0, 0)); },
			[](Loop& l) { l.rig.world.setGravity(btVector3(0, btScalar(-9.81), 0)), l.putBack(); }},
		{"a watched pair", kBodyIsGone, [](Loop& l) { l.rig.world.pairFilter().addPair(l.box, l.rig.bodies[0].get()); },
			[](Loop& l) { l.rig.world.pairFilter().acceptAllPairs(); }},
		{"a watched region", kBodyIsGone, [far](Loop& l) { (void)l.rig.world.pairFilter().setRegion(far, 2 * far); },
			[](Loop& l) { l.rig.world.pairFilter().clearRegion(), l.putBack(); }},
		{"a force error", {}, [](Loop& l) { (void)l.rig.world.setForceError(0.1); }, [](Loop& l) { (void)l.rig.world.setForceError(0); }},
		{"pairs that are made anew", {}, [](Loop& l) { l.rig.world.registration().cleanPairs(l.rig.world.bullet().getPairCache()); },
			[](Loop& l) { l.rig.world.registration().cleanPairs(l.rig.world.bullet().getPairCache()); }},
		{"a hand that is removed", kBodyIsGone, [](Loop& l) { l.rig.coupling.remove(l.source); },
			[](Loop& l) { l.rig.coupling.add(l.source); }},
		{"another hand", {},
			[](Loop& l) {
				l.other = std::make_unique<Hand>(l.rig.ballShape, ballTree(), l.rig.clock, Vec3{0.05, 0.03, 0}, handSettings());
				l.rig.coupling.add(l.other->source);
			},
			[](Loop& l) {
				l.rig.coupling.remove(l.other->source);
				l.other = nullptr;
			}}};
}

const std::vector<Feature>& features()
{
	static const std::vector<Feature> all = [] {
		std::vector<Feature> list = featuresOfDevice();
		for (const auto& more : {featuresOfBody(), featuresOfWorld()}) list.insert(list.end(), more.begin(), more.end());
		return list;
	}();
	return all;
}

/// What a tool feels without features.
double pressing(const Tool& tool)
{
	static std::map<const Tool*, double> known;
	if (known.count(&tool) == 0)
	{
		Loop l(tool);
		l.run(kApproach + kOn + kBoth);
		known[&tool] = l.judgedMost;
	}
	return known[&tool];
}

void expectFelt(const Loop& l, const Effect& effect, double pressed)
{
	EXPECT_LE(l.largest, 4.5 * pressed);
	if (effect.silent)
	{
		EXPECT_LE(l.judgedMost, effect.feelsNothing ? 0 : 0.6);
		return;
	}
	EXPECT_EQ(l.thread.state().flags, kReady);
	EXPECT_LE(l.judgedMost, (1 + effect.share) * pressed);
	if (!effect.atNewPlace)
	{
		EXPECT_GE(l.judgedLeast, (1 - effect.share) * pressed);
	}
	EXPECT_EQ(l.thread.faultCause(), FaultCause::None) << describe(l.thread.faultCause());
}

Effect together(const Effect& a, const Effect& b)
{
	const bool nothing = (a.silent && a.feelsNothing) || (b.silent && b.feelsNothing);
	return {
		a.silent || b.silent, a.cause != FaultCause::None ? a.cause : b.cause, a.share + b.share, a.atNewPlace || b.atNewPlace, nothing};
}

/// The hand has gone up: nothing pulls at it, the tool is where it is, and a body that leaves is let go.
void expectFree(Loop& l)
{
	const DeviceState hand = l.thread.state();
	EXPECT_LE(norm(l.thread.wantedWrench().force), 0.1);
	// The passivity controller may still take back what a body gave that came in where the tool was.
	EXPECT_LE(dot(l.thread.sentWrench().force, hand.twist.linear), 1e-2);
	EXPECT_LT(distance(l.source.toolState().X_WT.translation, hand.X_WH.translation), 3e-3);  // a gap of the samples is still being bridged
	EXPECT_EQ(l.thread.step().contactCount, 0);
	EXPECT_EQ(l.rig.coupling.crowded(), 0U);
	const std::weak_ptr<const ist::InnerSphereTree> tree = l.rig.world.registration().registry().find(&l.shape);
	EXPECT_FALSE(tree.expired());
	l.rig.coupling.forget(l.box);
	l.rig.world.bullet().removeRigidBody(l.box);
	l.attached.detach();
	l.run(40);
	EXPECT_TRUE(tree.expired()) << tree.use_count();
	l.rig.world.bullet().addRigidBody(l.box);
}

void tryPair(const Tool& tool, const Feature& a, const Feature& b)
{
	SCOPED_TRACE(std::string(tool.name) + ": " + a.name + ", then " + b.name);
	const double pressed = pressing(tool);
	const bool alone = &a == &b;
	if (!alone && a.effect.atNewPlace && b.effect.atNewPlace) return;  // together they may put the handle into the table
	const Effect both = alone ? a.effect : together(a.effect, b.effect);
	Loop l(tool);
	l.run(kApproach);
	a.on(l);
	l.run(kOn);
	if (!alone) b.on(l);
	l.run(kBoth);
	{
		SCOPED_TRACE("both on");
		expectFelt(l, both, pressed);
		EXPECT_EQ(l.thread.faults() > 0, both.cause != FaultCause::None) << l.thread.faults();
	}
	if (!alone) a.off(l);
	l.run(kOne);
	{
		SCOPED_TRACE("the second on");
		Effect second = b.effect;
		second.atNewPlace = both.atNewPlace;
		second.share = both.share;
		expectFelt(l, second, pressed);
	}
	b.off(l);
	l.run(kOff);
	{
		SCOPED_TRACE("both off");
		Effect none;
		none.atNewPlace = both.atNewPlace;
		none.share = std::max(a.effect.share, b.effect.share);
		expectFelt(l, none, pressed);
	}
	l.lift();
	l.run(kFree);
	SCOPED_TRACE("let go");
	expectFree(l);
}

std::string asName(std::string text)
{
	for (char& c : text) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
	return text;
}
}  // namespace

class FeaturePairsOfAHand : public testing::TestWithParam<size_t>
{};

TEST_P(FeaturePairsOfAHand, GetAlong)
{
	// Each pair once, every other one the other way round.
	for (size_t i = 0; i < GetParam(); ++i)
	{
		const Feature &one = features()[GetParam()], &other = features()[i];
		(GetParam() + i) % 2 == 0 ? tryPair(kTools[0], one, other) : tryPair(kTools[0], other, one);
	}
}

INSTANTIATE_TEST_SUITE_P(All, FeaturePairsOfAHand, testing::Range(size_t(0), features().size()),
	[](const auto& info) { return asName(features()[info.param].name); });

class FeaturesOfATool : public testing::TestWithParam<size_t>
{};

TEST_P(FeaturesOfATool, GetAlong)
{
	for (const Feature& feature : features()) tryPair(kTools[GetParam()], feature, feature);
}

INSTANTIATE_TEST_SUITE_P(All, FeaturesOfATool, testing::Range(size_t(0), std::size(kTools)),
	[](const auto& info) { return std::string(kTools[info.param].name); });
