// SPDX-License-Identifier: Zlib
#include "demos/scenes/Assembly/AssemblyRun.h"

#include "BulletISTCollision/Registry/btISTConversion.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>

using namespace ist;

namespace scenes
{
namespace
{
constexpr double kSampleEvery = 0.02;                                // [s]
constexpr double kPegHalf = 0.03, kTubeHalf = 0.02, kHole = 0.0105;  // of the scene files [m]

/// Watches peg and tube in each tick.
class AssemblyJudge
{
public:
	explicit AssemblyJudge(size_t ticks) { m_rows.reserve(ticks); }

	bool look(devicebridge::SteppingThread& thread, const SceneWorld& world)
	{
		if (!m_peg)
			for (size_t i = 0; i < world.size(); ++i)
			{
				if (world.body(i).name == "peg") m_peg = &world.body(i);
				if (world.body(i).name == "tube") m_tube = &world.body(i);
			}
		Row row;
		row.X_TP = inverse(poseOf(*m_tube)) * poseOf(*m_peg);
		const devicebridge::ToolStep& step = thread.step();
		for (int i = 0; i < step.contactCount; ++i)
			if (step.contacts[i].other == m_tube->body.get()) row.contact = norm(step.contacts[i].onTool.force), row.touches = true;
		if (m_rows.size() < m_rows.capacity()) m_rows.push_back(row);
		return true;
	}

	AssemblyTrial finish(const SceneOutcome& run) const;

private:
	struct Row
	{
		Pose X_TP;  // mesh frame of the peg in that of the tube
		double contact = 0;
		bool touches = false;
	};
	static Pose poseOf(const SceneWorld::Body& body) { return toPose(body.body->getWorldTransform()) * inverse(body.X_MP); }
	/// The peg's lower end in the frame of the tube.
	static Vec3 endOf(const Row& row) { return row.X_TP * Vec3{0, 0, -kPegHalf}; }

	const SceneWorld::Body *m_peg = nullptr, *m_tube = nullptr;
	std::vector<Row> m_rows;
};

AssemblyTrial AssemblyJudge::finish(const SceneOutcome& run) const
{
	AssemblyTrial trial;
	trial.sound = run.ok();
	const std::vector<SceneTick>& ticks = run.hands.front().ticks;
	const size_t count = std::min(m_rows.size(), ticks.size());
	size_t touched = 0;
	double next = 0;
	for (size_t i = 0; i < count; ++i)
	{
		const Vec3 end = endOf(m_rows[i]);
		// A peg beside the tube is not in it.
		AssemblySample now{ticks[i].time, std::hypot(end.x, end.y) < kHole ? std::max(0.0, kTubeHalf - end.z) : 0, 0};
		for (const SceneHandRun& hand : run.hands)
		{
			if (i >= hand.ticks.size()) continue;
			now.force = std::max(now.force, norm(hand.ticks[i].wrench.force));
			trial.maxTorque = std::max(trial.maxTorque, norm(hand.ticks[i].wrench.torque));
		}
		trial.maxContact = std::max(trial.maxContact, m_rows[i].contact);
		if (touched > 0 || m_rows[i].touches)
		{
			++touched;
			trial.meanForce += now.force;
			trial.maxForce = std::max(trial.maxForce, now.force);
		}
		if (!trial.done) trial.time = now.time;
		trial.done = trial.done || now.depth >= kWantedDepth;
		if (now.time + 1e-9 < next) continue;
		next += kSampleEvery;
		trial.samples.push_back(now);
	}
	if (count == 0) return trial;
	const Row& last = m_rows[count - 1];
	const Vec3 end = endOf(last), axis = last.X_TP.rotation * Vec3{0, 0, 1};
	trial.meanForce /= static_cast<double>(std::max<size_t>(touched, 1));
	trial.tilt = std::atan2(std::hypot(axis.x, axis.y), axis.z);
	trial.offCentre = std::hypot(end.x, end.y);
	return trial;
}

/// Refuses a scene without the bodies that AssemblyJudge watches.
std::optional<Error> checkBodies(const Scene& scene, const std::string& file)
{
	for (const char* name : {"peg", "tube"})
		if (!scene.hasBody(name)) return Error{file + ": no body is called " + name};
	return std::nullopt;
}

/// The path of a hand that holds its tool with an error from the second frame on.
void mislead(SceneHand& hand, const HandError& error)
{
	const Mat3 turn = rotationMatrix(quaternionFromRotationVector(error.turn));
	for (size_t i = 1; i < hand.path.size(); ++i)
		hand.path[i].X_BM = {turn * hand.path[i].X_BM.rotation, hand.path[i].X_BM.translation + error.offset};
}
}  // namespace

HandError handError(std::uint64_t seed, double offsetSigma, double turnSigma)
{
	std::mt19937_64 random(seed);
	const auto uniform = [&] { return (static_cast<double>(random() >> 11) + 0.5) * 0x1p-53; };
	// Box and Muller; the distributions of the standard library differ between libraries.
	const auto normal = [&] {
		const double size = std::sqrt(-2 * std::log(uniform()));
		return size * std::cos(6.283185307179586 * uniform());
	};
	HandError error;
	error.offset.x = offsetSigma * normal();
	error.offset.z = offsetSigma * normal();
	error.turn.x = turnSigma * normal();
	error.turn.z = turnSigma * normal();
	return error;
}

Result<std::vector<AssemblyCondition>> runAssembly(const AssemblyOptions& options)
{
	std::vector<AssemblyCondition> conditions;
	for (const int hands : {1, 2})
	{
		const char* const name = hands == 1 ? "assembly-one-hand.json" : "assembly-two-hands.json";
		const std::string file = (std::filesystem::path(options.scenes) / name).string();
		const Result<Scene> read = loadScene(file);
		if (!read) return read.error();
		if (auto refused = checkBodies(read.value(), file)) return *refused;
		for (const int freedoms : {3, 6})
		{
			AssemblyCondition condition{hands, freedoms, {}};
			for (int trial = 0; trial < options.trials; ++trial)
			{
				Scene scene = read.value();
				for (size_t i = 0; i < scene.hands.size(); ++i)
				{
					// All trials with this number have these errors, whatever is felt.
					const std::uint64_t seed = 1000 * options.seed + 10 * static_cast<std::uint64_t>(trial) + i;
					mislead(scene.hands[i], handError(seed, options.offsetSigma, options.turnSigma));
					scene.hands[i].device += freedoms == 3 ? "?dof=3" : "?dof=6";
				}
				AssemblyJudge judge(static_cast<size_t>(1000 * scene.duration));
				SceneRunOptions run{options.build, true, {}};
				run.build.progress = [&](const char* stage, double share) {
					const bool isRun = std::string(stage) == "hand";
					const double all = 4.0 * options.trials, before = static_cast<double>(conditions.size()) * options.trials + trial;
					return !options.build.progress ||
						options.build.progress(isRun ? "trials" : stage, isRun ? (before + share) / all : share);
				};
				run.listener = [&judge](
								   devicebridge::SteppingThread& thread, const SceneWorld& world) { return judge.look(thread, world); };
				const Result<SceneOutcome> outcome = runScene(scene, run);
				if (!outcome) return outcome.error();
				condition.trials.push_back(judge.finish(outcome.value()));
			}
			conditions.push_back(std::move(condition));
		}
	}
	return conditions;
}
}  // namespace scenes
