// SPDX-License-Identifier: Zlib
#include "DeviceBridge/Bullet/BulletDecoupledSource.h"

#include "BulletHapticForce/World/btISTWorld.h"
#include "BulletISTCollision/Core/Base/ThreadTime.h"
#include "BulletISTCollision/Registry/btISTConversion.h"
#include "DeviceBridge/Bullet/BulletShapeParts.h"
#include "DeviceBridge/Platform/RealTimePriority.h"

#include "BulletDynamics/Dynamics/btRigidBody.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>

namespace devicebridge
{
namespace
{
double microsecondsSince(std::chrono::steady_clock::time_point begin)
{
	return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count();
}

constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// Weight 1 up to `trusted`, 0 from twice that on.
double trust(double way, double trusted) { return std::clamp(2 - way / trusted, 0.0, 1.0); }

const char* whyNotSlots(int slots)
{
	static_assert(kMostMirroredBodies == 1024, "the sentence names it");
	return slots >= 1 && slots <= kMostMirroredBodies ? ""
													  : "the setting slots must be 1 to 1024: it is the number of bodies near the tool";
}

}  // namespace

BulletDecoupledSource::BulletDecoupledSource(
	btRigidBody& tool, std::shared_ptr<const ist::InnerSphereTree> tree, Clock& clock, const BulletDecoupledSettings& settings)
	: BulletDecoupledSource(tool, {toolPartOf(std::move(tree))}, {}, clock, settings)
{}

BulletDecoupledSource::BulletDecoupledSource(btISTWorld& world, btRigidBody& tool, Clock& clock, const BulletDecoupledSettings& settings)
	: BulletDecoupledSource(tool, toolPartsOf(world.registration().registry(), *tool.getCollisionShape()),
		  unfeltPartsOf(world.registration().registry(), *tool.getCollisionShape()), clock, settings)
{}

BulletDecoupledSource::BulletDecoupledSource(btRigidBody& tool, std::vector<ToolPart> parts, std::vector<UnfeltToolPart> unfelt,
	Clock& clock, const BulletDecoupledSettings& settings)
	: m_tool(tool),
	  m_parts(std::move(parts)),
	  m_unfeltParts(std::move(unfelt)),
	  m_slots(whyNotSlots(settings.slots)[0] == '\0' ? settings.slots : kMirroredBodies),
	  m_time(clock),
	  m_settings(settings),
	  m_coupling(settings.gains),
	  m_X_WB(inverse(settings.X_BW)),
	  m_topology(settings.topology),
	  m_mirror(m_slots),
	  m_local(m_slots),
	  m_finder(m_parts, settings.maxPairs),
	  m_touching(std::size_t(kToolContactsPerSlot * m_slots)),
	  m_contactOf(std::size_t(m_slots)),
	  m_touched(std::size_t(m_slots)),
	  m_stiffness(m_slots),
	  m_lastTopology(settings.topology),
	  m_questions(m_slots),
	  m_answers(m_slots),
	  m_threadFinder(m_parts, settings.maxPairs),
	  m_lastQuestion(std::size_t(m_slots))
{
	const ist::Vec3 inverseInertia = toVec3(tool.getInvInertiaDiagLocal());
	m_refusal = whyNotCoupled(settings.gains, double(tool.getInvMass()), inverseInertia);
	if (m_refusal[0] == '\0' && !settings.mayBeSilent) m_refusal = whyNotMoved(settings.gains);
	if (m_refusal[0] == '\0') m_refusal = whyNotSlots(settings.slots);
	if (m_refusal[0] == '\0' && m_parts.empty())
		m_refusal = "no part of the tool can be felt: attach a tree to its shape, or to a child of its compound, before it is coupled";
	const bool accepted = m_refusal[0] == '\0', hasMass = accepted && tool.getInvMass() > 0;
	m_local.tool.mass = hasMass ? 1 / double(tool.getInvMass()) : kInfinite;
	for (int i = 0; i < 3; ++i) m_local.tool.inverseInertia.m[i][i] = accepted ? inverseInertia[i] : 0;
	m_leastInertia = 1 / std::max({inverseInertia.x, inverseInertia.y, inverseInertia.z});
	// A tool that never moves has no weight that could be felt; infinity times zero would not be a number.
	if (settings.gravity && hasMass) m_local.tool.gravity = toVec3(tool.getGravity());
	if (hasMass) m_weight = m_local.tool.mass * m_local.tool.gravity;
	m_local.tool.state = {toPose(tool.getWorldTransform()), {toVec3(tool.getLinearVelocity()), toVec3(tool.getAngularVelocity())}};
	m_threadFinder.measure();
	m_worldAge.fullUntil = m_answerAge.fullUntil = settings.fullUntil;
	m_worldAge.zeroFrom = m_answerAge.zeroFrom = settings.zeroFrom;
	post();
}

BulletDecoupledSource::~BulletDecoupledSource() { stopContactThread(); }

std::shared_ptr<const ist::InnerSphereTree> BulletDecoupledSource::toolTree() const noexcept
{
	for (const ToolPart& part : m_parts)
		if (part.tree) return part.tree;
	return nullptr;
}

void BulletDecoupledSource::reserve(const ist::InnerSphereTree& tree)
{
	m_finder.reserve(tree);
	m_threadFinder.reserve(tree);
}

ToolState BulletDecoupledSource::toolState() const noexcept
{
	const ToolState& t = m_local.tool.state;
	const ist::Mat3& R_WB = m_X_WB.rotation;
	return {m_X_WB * t.X_WT, {R_WB * t.twist.linear, R_WB * t.twist.angular}};
}

void BulletDecoupledSource::advance(double dt, const DeviceState& hand, ToolStep& step) noexcept
{
	if (m_settings.gains.isStatic && !(dt > 0))  // the tool's mass is that of a spring times the square of the step
	{
		step.coupling = {};
		step.tool = toolState();
		return;
	}
	const std::int64_t now = m_time.now();
	takeSnapshot(now);
	const double factor = m_worldAge.factor(now);
	if (factor < 1) m_fadedTicks.fetch_add(1, std::memory_order_relaxed);
	m_local.hold(factor == 0);
	step.overdue = m_worldAge.known() ? m_worldAge.overdue(now) : 0;

	const auto begin = std::chrono::steady_clock::now();
	step.queryMicroseconds = 0;
	m_touchingCount = 0;
	if (m_refusal[0] == '\0') findContacts(now, step);
	if (topology() == ContactThreading::InHapticThread) step.queryMicroseconds = microsecondsSince(begin);
	const bool isFoundAnew = m_lastTopology == ContactThreading::InHapticThread;
	if (isFoundAnew) m_stiffness.stiffen(m_touching.data(), m_touchingCount, m_mirror.snapshot(), m_local.tool.mass, dt);
	weighContacts(dt, factor);
	DeviceState leading = hand;
	step.coupling = {};
	if (m_switch.lead(leading, toolState(), dt))
	{
		adapt(dt, leading);
		forgetMomentum(dt);
		step.coupling = pull(dt, leading);
	}
	const ist::Mat3& R_BW = m_settings.X_BW.rotation;
	const ist::Vec3 origin = m_local.tool.state.X_WT.translation;
	m_local.step(dt, {R_BW * step.coupling.force, R_BW * step.coupling.torque}, m_touching.data(), m_touchingCount, m_mirror.snapshot());
	if (isFoundAnew) m_stiffness.note(m_touching.data(), m_touchingCount, m_local, dt);
	step.tool = toolState();
	step.toolIsBroken = m_local.toolIsBroken();
	if (step.toolIsBroken) m_brokenSteps.fetch_add(1, std::memory_order_relaxed);
	step.couplingFactor = m_coupling.factor();
	if (m_settings.gains.isStatic) step.coupling = staticWrench(m_coupling.gains(), step.coupling, step.tool.twist, dt);
	fill(dt, origin, step);
	post();
}

void BulletDecoupledSource::takeSnapshot(std::int64_t now) noexcept
{
	if (m_mirror.fetch())
	{
		const WorldSnapshot& world = m_mirror.snapshot();
		m_worldAge.arrived(now, static_cast<std::int64_t>(1e9 * world.period));
		m_local.reconcile(world);
		m_stiffness.take(world);
		m_worldSteps.fetch_add(1, std::memory_order_relaxed);
	}
	const std::int64_t age = m_worldAge.known() ? m_worldAge.age(now) : 0;
	m_age.store(age, std::memory_order_relaxed);
	m_longestAge.store(std::max(age, m_longestAge.load(std::memory_order_relaxed)), std::memory_order_relaxed);
	m_period.store(m_worldAge.period(), std::memory_order_relaxed);
}

/// Adapts the coupling to the contacts of this step.
void BulletDecoupledSource::adapt(double dt, const DeviceState& hand) noexcept
{
	if (!m_coupling.adapts() || !(dt > 0)) return;
	ist::SymmetricMatrix6 resistance;
	bool rigid = false;
	for (int i = 0; i < m_touchingCount; ++i)
	{
		const LinearContact& c = touching(i);
		addResistance(resistance, c.stiffness, c.damping, c.point - m_local.tool.state.X_WT.translation, dt);
		rigid = rigid || c.friction > 0;
	}
	const bool hasMass = !m_settings.gains.isStatic;
	// No spring acts on a degree of freedom in which the tool cannot move.
	const auto momentum = [&](double inert) { return hasMass && std::isfinite(inert) ? inert : 0; };
	m_coupling.adapt(resistance, rigid, momentum(m_local.tool.mass), momentum(m_leastInertia), hand.X_WH, toolState().X_WT, dt);
}

ist::Wrench BulletDecoupledSource::pull(double dt, const DeviceState& hand) const noexcept
{
	if (m_refusal[0] != '\0' || !isRigid(hand.X_WH) || !isFinite(hand.twist)) return {};
	if (m_settings.gains.isStatic) return staticPull(m_coupling.gains(), hand.X_WH, toolState().X_WT);
	const ist::Wrench wanted = couplingOnTool(
		m_coupling.gains(), hand.X_WH, hand.twist, toolState(), m_local.tool.mass, m_leastInertia, dt);
	return isFinite(wanted) ? wanted : ist::Wrench();
}

/// Clears the tool's momentum before a step on a static coupling.
void BulletDecoupledSource::forgetMomentum(double dt) noexcept
{
	const CouplingGains& gains = m_coupling.gains();
	LocalTool& tool = m_local.tool;
	if (!gains.isStatic) return;
	if (gains.stiffness > 0)
	{
		tool.mass = staticMass(gains.stiffness, dt);
		tool.gravity = m_weight / tool.mass;
		tool.state.twist.linear = {};
	}
	if (!(gains.angularStiffness > 0)) return;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) tool.inverseInertia.m[i][j] = i == j ? 1 / staticMass(gains.angularStiffness, dt) : 0;
	tool.state.twist.angular = {};
}

void BulletDecoupledSource::findContacts(std::int64_t now, ToolStep& step) noexcept
{
	const ContactThreading wanted = topology();
	// Taken in every mode, because bodies are released only after the last question about them was answered.
	takeAnswer();
	if (wanted != m_lastTopology)
	{
		m_answerAge.forget();
		m_stiffness.forget();
		m_stiffness.take(m_mirror.snapshot());
		if (wanted == ContactThreading::OwnThread && m_answers.readable().number > 0) m_answerAge.arrived(m_answers.readable().askedAt, 0);
	}
	m_lastTopology = wanted;
	const WorldSnapshot& world = m_mirror.snapshot();
	m_droppedContacts.store(world.droppedContacts, std::memory_order_relaxed);
	if (wanted != ContactThreading::OwnThread) takeQuestionBack();
	if (wanted == ContactThreading::InHapticThread) askInHapticThread(step);
	else if (wanted == ContactThreading::OwnThread)
	{
		feelAnswer(now, step);
		ask(now);
	}
	else
	{
		if (world.step != m_toolAnswers) m_toolAnswers = world.step, m_modelAnswers.fetch_add(1, std::memory_order_relaxed);
		m_coarsened.store(world.coarsenedQueries, std::memory_order_relaxed);
		m_overBudget.store(world.queriesOverBudget, std::memory_order_relaxed);
		m_refused.store(world.refusedQueries, std::memory_order_relaxed);
		m_dropped.store(world.droppedPatches, std::memory_order_relaxed);
		takeModel(world.toolContacts, world.toolContactCount, 1);
		for (int i = 0; i < m_touchingCount; ++i) step.overlapVolume += touching(i).volume;
	}
}

void BulletDecoupledSource::askInHapticThread(ToolStep& step) noexcept
{
	const WorldSnapshot& world = m_mirror.snapshot();
	const int capacity = static_cast<int>(m_touching.size());
	for (int i = 0; i < world.pairCount; ++i)
	{
		const MirroredPair& pair = world.pairs[std::size_t(i)];
		const MirroredBody& body = mirrored(pair.slot);
		if (body.epoch == 0 || body.leaving) continue;
		const int first = m_touchingCount;
		m_touchingCount += m_finder.find(m_local.tool.state.X_WT, pair, body, m_local.body(pair.slot).spent.X_WB, m_touching.data() + first,
			capacity - first, step.overlapVolume);
		for (int k = first; k < m_touchingCount; ++k) m_touching[std::size_t(k)].pair = i;
	}
	m_coarsened.store(m_finder.coarsened(), std::memory_order_relaxed);
	m_overBudget.store(m_finder.overBudget(), std::memory_order_relaxed);
	m_refused.store(m_finder.refused(), std::memory_order_relaxed);
	m_dropped.store(m_finder.dropped(), std::memory_order_relaxed);
}

void BulletDecoupledSource::takeAnswer() noexcept
{
	if (!m_answers.fetch()) return;
	const Answer& answer = m_answers.readable();
	m_settled = std::max(m_settled, answer.number);
	m_modelAnswers.fetch_add(1, std::memory_order_relaxed);
	m_coarsened.store(answer.coarsened, std::memory_order_relaxed);
	m_overBudget.store(answer.overBudget, std::memory_order_relaxed);
	m_refused.store(answer.refused, std::memory_order_relaxed);
	m_dropped.store(answer.dropped, std::memory_order_relaxed);
	if (m_lastTopology == ContactThreading::OwnThread) m_answerAge.arrived(answer.askedAt, 0);
}

void BulletDecoupledSource::feelAnswer(std::int64_t now, ToolStep& step) noexcept
{
	const Answer& answer = m_answers.readable();
	step.queryMicroseconds = answer.microseconds;
	if (!m_answerAge.known()) return;
	takeModel(answer.contacts, answer.count, m_answerAge.factor(now));
	step.overlapVolume = answer.volume;
}

/// At most one question is open at a time, because the trees in it must live until it was answered or withdrawn.
void BulletDecoupledSource::ask(std::int64_t now) noexcept
{
	const WorldSnapshot& world = m_mirror.snapshot();
	// A thread that does not run would otherwise keep a leaving body for ever.
	for (int slot = 0; slot < m_slots; ++slot)
		if (mirrored(slot).leaving && !mayRelease(slot)) takeQuestionBack();
	if (awaitsAnswer()) return;
	Question& question = m_questions.writable();
	question.number = ++m_asked;
	question.askedAt = now;
	question.X_WT = m_local.tool.state.X_WT;
	for (int slot = 0; slot < m_slots; ++slot)
	{
		const MirroredBody& body = mirrored(slot);
		MirroredBody& asked = question.bodies[std::size_t(slot)];
		// Only occupied slots are copied, because most are empty and a body is large.
		asked.epoch = body.epoch;
		if (body.epoch == 0) continue;
		asked = body;
		asked.X_WB = m_local.body(slot).spent.X_WB;
		if (!asked.leaving) m_lastQuestion[std::size_t(slot)] = m_asked;
	}
	std::copy(world.pairs.begin(), world.pairs.begin() + world.pairCount, question.pairs.begin());
	question.pairCount = world.pairCount;
	m_triedToTakeBack = false;
	m_questions.publish();
	m_thread.wake();
}

/// Replaces a question that no thread has begun by an empty one. If a thread has begun it, its answer will come, so one attempt is enough.
void BulletDecoupledSource::takeQuestionBack() noexcept
{
	if (!awaitsAnswer() || m_triedToTakeBack) return;
	m_triedToTakeBack = true;
	m_questions.writable().number = 0;
	if (m_questions.publish()) m_settled = m_asked;
}

/// Takes the linear models of bodies that still have their slots, moved to the present poses of tool and copies.
void BulletDecoupledSource::takeModel(const std::vector<LinearContact>& contacts, int count, double factor) noexcept
{
	std::optional<ContactMotion> motion;
	int motionOf = -1;
	for (int i = 0; i < count; ++i)
	{
		const LinearContact& found = contacts[std::size_t(i)];
		const int slot = found.b;
		const MirroredBody& body = mirrored(slot);
		if (body.epoch == 0 || body.leaving || body.epoch != found.epoch) continue;
		// The patches of one body are consecutive and were found at the same poses.
		if (motionOf != slot) motion.emplace(found, m_local.tool.state.X_WT, m_local.body(slot).spent.X_WB);
		motionOf = slot;
		double way = 0;
		LinearContact& moved = m_touching[std::size_t(m_touchingCount)] = movedTo(found, *motion, &way);
		if (!(dot(moved.wrench.force, moved.normal) > 0)) continue;
		multiply(moved, factor * trust(way, m_settings.trustedModel));
		++m_touchingCount;
	}
}

/// Scales each contact by how far its copy is trusted, the world is in time, and the contact has faded in.
void BulletDecoupledSource::weighContacts(double dt, double factor) noexcept
{
	std::fill(m_touched.begin(), m_touched.end(), false);
	for (int i = 0; i < m_touchingCount; ++i) m_touched[std::size_t(touching(i).b)] = true;
	for (int slot = 0; slot < m_slots; ++slot)
	{
		double& share = m_local.body(slot).share;
		if (factor > 0) share = m_touched[std::size_t(slot)] ? std::min(1.0, share + dt / m_settings.fadeIn) : 1;
	}
	for (int i = 0; i < m_touchingCount; ++i)
	{
		LinearContact& c = m_touching[std::size_t(i)];
		const BulletLocalWorld::Body& body = m_local.body(c.b);
		const double way = distance(body.spent.X_WB.translation, mirrored(c.b).X_WB.translation);
		multiply(c, factor * body.share * trust(way, m_settings.trustedWay));
	}
}

void BulletDecoupledSource::fill(double dt, const ist::Vec3& origin, ToolStep& step) noexcept
{
	const ist::Mat3& R_WB = m_X_WB.rotation;
	const double rate = dt > 0 ? 1 / dt : 0;
	std::fill(m_contactOf.begin(), m_contactOf.end(), -1);
	for (int i = 0; i < m_touchingCount; ++i)
	{
		const LinearContact& c = touching(i);
		step.pairs += c.pairs;
		int& at = m_contactOf[std::size_t(c.b)];
		if (at < 0)
		{
			if (step.contactCount == kMaxToolContacts) continue;
			at = step.contactCount++;
			step.contacts[at] = {};
			step.contacts[at].other = mirrored(c.b).id;
		}
		ToolContact& out = step.contacts[at];
		const ist::Wrench& impulse = m_local.impulse(i);
		out.onTool.force += R_WB * (rate * impulse.force);
		out.onTool.torque += R_WB * (rate * (impulse.torque + cross(c.point - origin, impulse.force)));
		out.point += c.volume * (m_X_WB * c.point);
		out.normal += R_WB * (c.volume * c.normal);
		out.volume += c.volume;
		out.pairs += c.pairs;
	}
	for (int i = 0; i < step.contactCount; ++i)
	{
		ToolContact& out = step.contacts[i];
		out.point = out.point / out.volume;
		out.normal = normalized(out.normal);
	}
}

bool BulletDecoupledSource::mayRelease(int slot) const noexcept { return m_settled >= m_lastQuestion[std::size_t(slot)]; }

void BulletDecoupledSource::post() noexcept
{
	HandPost& out = m_mirror.post();
	out.tick = ++m_tick;
	out.tool = m_local.tool.state;
	for (int slot = 0; slot < m_slots; ++slot)
	{
		const SpentImpulse& spent = m_local.body(slot).spent;
		SpentImpulse& posted = out.bodies[std::size_t(slot)];
		if (spent.epoch == 0) posted.epoch = 0;
		else posted = spent;
		posted.released = mirrored(slot).leaving && mayRelease(slot);
	}
	m_mirror.send();
}

bool BulletDecoupledSource::serveContacts() noexcept
{
	if (!m_questions.fetch()) return false;
	const Question& question = m_questions.readable();
	if (question.number == 0) return false;
	Answer& answer = m_answers.writable();
	answer.number = question.number;
	answer.askedAt = question.askedAt;
	answer.count = 0;
	answer.volume = 0;
	const auto begin = std::chrono::steady_clock::now();
	const double asked = m_threadFinder.queryMicroseconds();
	for (int i = 0; i < question.pairCount; ++i)
	{
		const MirroredPair& pair = question.pairs[std::size_t(i)];
		const MirroredBody& body = question.bodies[std::size_t(pair.slot)];
		if (body.epoch == 0 || body.leaving) continue;
		answer.count += m_threadFinder.find(question.X_WT, pair, body, body.X_WB, answer.contacts.data() + answer.count,
			static_cast<int>(answer.contacts.size()) - answer.count, answer.volume);
	}
	answer.microseconds = microsecondsSince(begin);
	answer.coarsened = m_threadFinder.coarsened();
	answer.overBudget = m_threadFinder.overBudget();
	answer.refused = m_threadFinder.refused();
	answer.dropped = m_threadFinder.dropped();
	const double used = ist::threadMicroseconds();
	answer.cost = {answer.number, 0, used - (m_threadTime < 0 ? used : m_threadTime), m_threadFinder.queryMicroseconds() - asked};
	for (int i = 0; i < answer.count; ++i) answer.cost.pairs += answer.contacts[std::size_t(i)].pairs;
	m_threadTime = used;
	m_answers.publish();
	return true;
}

bool BulletDecoupledSource::startContactThread()
{
	const auto begin = [this] {
		m_threadTime = ist::threadMicroseconds();
		if (m_settings.realTime) m_contactRealTime = askForRealTimePriority(m_settings.priority).granted;
	};
	return m_thread.start(begin, [this] { return serveContacts(); });
}

void BulletDecoupledSource::stopContactThread() noexcept
{
	m_thread.stop();
	m_threadTime = -1;
}

ist::Vec3 BulletDecoupledSource::undelivered() const noexcept
{
	ist::Vec3 sum;
	for (int slot = 0; slot < m_slots; ++slot)
	{
		const SpentImpulse &spent = m_local.body(slot).spent, &seen = mirrored(slot).seen;
		if (spent.epoch != 0) sum += spent.impulse.force - (seen.epoch == spent.epoch ? seen.impulse.force : ist::Vec3());
	}
	return sum;
}

bool BulletDecoupledSource::copyOf(const void* object, ist::Pose& X_WB) const noexcept
{
	for (int slot = 0; slot < m_slots; ++slot)
	{
		if (m_local.body(slot).spent.epoch == 0 || mirrored(slot).id != object) continue;
		X_WB = m_local.body(slot).spent.X_WB;
		return true;
	}
	return false;
}

DecoupledStatistics BulletDecoupledSource::statistics() const noexcept
{
	const auto read = [](const auto& value) { return value.load(std::memory_order_relaxed); };
	DecoupledStatistics s;
	s.worldSteps = read(m_worldSteps);
	s.modelAnswers = read(m_modelAnswers);
	s.fadedTicks = read(m_fadedTicks);
	s.coarsenedQueries = read(m_coarsened);
	s.queriesOverBudget = read(m_overBudget);
	s.refusedQueries = read(m_refused);
	s.droppedPatches = read(m_dropped);
	s.droppedContacts = read(m_droppedContacts);
	s.brokenSteps = read(m_brokenSteps);
	s.contactRealTime = read(m_contactRealTime);
	s.modelAge = 1e-9 * static_cast<double>(read(m_age));
	s.longestModelAge = 1e-9 * static_cast<double>(read(m_longestAge));
	s.period = 1e-9 * static_cast<double>(read(m_period));
	return s;
}
}  // namespace devicebridge
