// SPDX-License-Identifier: Zlib
#include "demos/browser/base/DemoSolid.h"
#include "demos/browser/base/SlidingBlock.h"

#include "BulletISTCollision/Core/Accuracy/LevelCalibration.h"
#include "BulletISTCollision/Core/Mesh/MeshShapes.h"
#include "demos/scenes/Extremes/AccuracySweep.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

using namespace ist;

namespace browser
{
namespace
{
constexpr double kSize = 0.2, kBall = 0.035, kStiffness = 1e7, kPi = 3.14159265358979323846;
constexpr double kTick = 1e-3;
constexpr int kTicksBetween = 100;                            // number of ticks between two poses that the quadrature judges
constexpr int kPoses = 60, kPeriod = kPoses * kTicksBetween;  // number of such poses, and of ticks, on the ball's path
constexpr int kMotionRate = 240;                              // [Hz]
constexpr double kFinest = 0.02, kCoarsest = 0.5;

/// The accuracy setting: the user chooses a tolerance, the error of the force that is accepted, and the library chooses the level of each
/// query. A ball rolls over a body and is queried at 1 kHz. Charts show the error bound, the cost and the true error for each accepted
/// error. The truth is an integral over the triangles. Beside it, a chart has the error of a motion for each step.
class Dial : public BrowsableDemo
{
public:
	std::optional<Error> prepare(const DemoOptions& options) override;
	std::optional<Error> restart() override;
	void step(double seconds) override;
	double stepSize() const override { return 1.0 / 60; }
	double duration() const override { return kPeriod * kTick; }
	double time() const override { return m_time; }
	Viewpoint viewpoint() const override { return {{m_top.x + 0.03, m_up + m_top.y + 0.005, m_top.z}, 0.3, 0.7, 0.4}; }
	DrawChoice firstChoice() const override { return {.leaves = true}; }
	void draw(const DrawChoice& choice, DrawList& list) override;
	std::vector<Parameter> parameters() override
	{
		return {{"error accepted", "%", &m_accepted, 100 * kFinest, 100 * kCoarsest, false, true}};
	}
	std::vector<Figure> figures() const override;
	std::vector<Curve> curves() const override { return {m_dial, m_errorBound, m_error, m_rate, m_pairs}; }
	std::vector<scenes::Chart> charts() const override;
	std::vector<std::string> report() const override;

private:
	std::optional<Error> prepareMotion(const DemoOptions& options);
	Pose X_AB(int tick) const;
	static double turned(double time);
	void tick();
	Vec3 forceOf(const OverlapResult& result) const { return pressureWrench(result.total, {}).force; }

	SolidPtr m_solids[2];
	InnerSphereTree m_trees[2];
	std::vector<scenes::JudgedPose> m_truths;
	std::vector<scenes::AccuracyPoint> m_sweep;
	scenes::Chart m_motion;    // error of a sliding block for each step
	double m_motionError = 0;  // at kMotionRate
	QueryWorkspace m_workspace;
	AdaptiveLevel m_pair;
	const BallTree* m_balls = nullptr;  // balls of the body at the level that answers
	Vec3 m_top, m_force, m_finest;      // forces for 1 Pa/m
	double m_floor = 0, m_up = 0, m_time = 0, m_accepted = 5, m_byItself = 5;
	int m_ticks = 0, m_judged = 0, m_held = 0;
	long long m_nowPairs = 0, m_nowBalls = 0;
	double m_nowError = 0, m_nowMicroseconds = 0, m_largestLeap = 0;
	Curve m_dial{"error accepted", "%", {}}, m_errorBound{"error bound", "%", {}}, m_error{"true error", "%", {}},
		m_rate{"queries a second", "Hz", {}}, m_pairs{"pairs", "", {}};
};

std::optional<Error> Dial::prepare(const DemoOptions& options)
{
	Result<Mesh> mesh = chosenMesh(options, kSize, knotMesh(kSize));
	if (!mesh) return mesh.error();
	const Mesh meshes[] = {mesh.value(), makeSphereMesh(kBall, 4)};
	for (const int i : {0, 1})
	{
		if (auto error = makeSolid(m_solids[i], i ? "ball" : "body", meshes[i], i ? 3000 : 8000, options)) return error;
		m_trees[i] = *m_solids[i]->tree;
		addLevels(m_trees[i]);
	}
	m_floor = forceFloor(m_trees[0], m_trees[1]);
	const Box box = bounds(m_solids[0]->mesh);
	m_up = -box.lower.y;
	for (const Vec3& p : m_solids[0]->mesh.vertices)
		if (p.y == box.upper.y) m_top = p;

	std::vector<Pose> poses;
	for (int i = 0; i < kPoses; ++i) poses.push_back(X_AB(i * kTicksBetween));
	m_truths = scenes::judgePoses(scenes::OverlapQuadrature(m_solids[0]->mesh, m_solids[1]->mesh), poses, 48, 8000);
	std::vector<double> accepted;
	for (int i = 0; i <= 12; ++i) accepted.push_back(kFinest * std::pow(kCoarsest / kFinest, i / 12.0));
	m_sweep = scenes::sweepAccuracy(m_trees[0], m_trees[1], m_truths, accepted);
	return prepareMotion(options);
}

std::optional<Error> Dial::prepareMotion(const DemoOptions& options)
{
	SlidingBlock block;
	if (auto error = block.prepare(options)) return error;
	m_motion = {"Error of a motion: a block that slides for half a second", "steps a second", "error [%]", {}, true};
	for (const scenes::Response response : {scenes::Response::Volumetric, scenes::Response::Stock})
	{
		scenes::ChartSeries line{response == scenes::Response::Stock ? "stock Bullet" : "motion", {}, {}, {}, false, -1};
		for (const int rate : {30, 60, 120, 240, 480, 960})
		{
			line.x.push_back(rate);
			line.y.push_back(100 * block.error(response, rate));
		}
		m_motion.series.push_back(std::move(line));
	}
	m_motionError = 100 * block.error(scenes::Response::Volumetric, kMotionRate);
	return std::nullopt;
}

std::optional<Error> Dial::restart()
{
	m_time = m_largestLeap = m_nowError = m_nowMicroseconds = 0;
	m_ticks = m_judged = m_held = 0;
	m_pair = {};
	for (Curve* curve : {&m_dial, &m_errorBound, &m_error, &m_rate, &m_pairs}) curve->values.clear();
	tick();
	return std::nullopt;
}

/// Pose on a path that goes from touch to touch, deeper and shallower, rolling around the top of the body.
Pose Dial::X_AB(int tick) const
{
	const double turn = 2 * kPi * tick / kPeriod, depth = 0.001 + 0.0075 * (1 + std::cos(3 * turn));
	Pose X;
	X.translation = m_top + Vec3{0.012 * std::sin(turn), kBall - depth, 0.012 * std::sin(2 * turn)};
	X.rotation = rotationMatrix(quaternionFromRotationVector({2 * std::sin(turn), 0.5, std::sin(2 * turn)}));
	return X;
}

/// The accuracy setting over time while the user has not changed it: jumps, as from a released mouse, and one continuous sweep from end
/// to end.
double Dial::turned(double time)
{
	const double t = std::fmod(time, kPeriod * kTick);
	if (t < 2) return t < 0.7 ? 5 : t < 1.3 ? 40 : 3;
	return t < 5 ? 100 * kFinest * std::pow(kCoarsest / kFinest, (t - 2) / 3) : 10;
}

void Dial::tick()
{
	ForceTolerance accepted;
	accepted.error = m_accepted / 100;
	const int at = m_ticks % kPeriod;
	const auto start = std::chrono::steady_clock::now();
	const OverlapResult result = queryAdaptive(m_trees[0], m_trees[1], X_AB(at), m_workspace, accepted, {}, m_pair);
	m_nowMicroseconds = 1e6 * std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
	m_nowPairs = result.total.pairs;
	m_nowBalls = (long long)(result.ballsA->ballCount() + result.ballsB->ballCount());
	m_balls = result.ballsA;
	const Vec3 force = forceOf(result), finest = forceOf(queryOverlap(m_trees[0], m_trees[1], X_AB(at), m_workspace));
	// The change of the leaves' force comes from the motion; the rest comes from the accuracy setting.
	if (m_ticks > 0)
		m_largestLeap = std::max(
			m_largestLeap, norm(force - m_force - (finest - m_finest)) / std::max({norm(force), norm(m_force), m_floor}));
	m_force = force;
	m_finest = finest;
	if (at % kTicksBetween == 0)
	{
		m_nowError = scenes::forceError(force, m_truths[size_t(at / kTicksBetween)], m_floor);
		++m_judged;
		m_held += m_nowError <= m_pair.errorBound;
	}
	++m_ticks;
}

void Dial::step(double seconds)
{
	m_time += seconds;
	const auto append = [](Curve& curve, double value) {
		if (curve.values.size() == 600) curve.values.erase(curve.values.begin());
		curve.values.push_back(float(value));
	};
	// The setting moves by itself until the user changes it.
	if (m_accepted == m_byItself) m_accepted = m_byItself = turned(m_time);
	while (m_ticks * kTick <= m_time) tick();
	append(m_dial, m_accepted);
	append(m_errorBound, 100 * m_pair.errorBound);
	append(m_error, 100 * m_nowError);
	append(m_rate, 1e6 / std::max(m_nowMicroseconds, 0.1));
	append(m_pairs, double(m_nowPairs));
}

std::vector<Figure> Dial::figures() const
{
	double held = 0, least = 1;
	for (const scenes::AccuracyPoint& p : m_sweep)
	{
		held += p.held / double(m_sweep.size());
		least = std::min(least, p.held);
	}
	const int judged = std::max(m_judged, 1);
	return {{"error accepted", "%", m_accepted}, {"error bound", "%", 100 * m_pair.errorBound}, {"level", "", double(m_pair.level)},
		{"spheres in contact", "", double(m_nowBalls)}, {"pairs", "", double(m_nowPairs)},
		{"true error, by quadrature on the triangles", "%", 100 * m_nowError},
		{"poses so far in which the bound held", "%", 100.0 * m_held / judged, 100, 5},
		{"the same, over all errors accepted", "%", 100 * held, 100, 5}, {"where it held least often", "%", 100 * least},
		// A change takes half a percent a query. At the first touch a coarser level may begin with the accepted share of the floor: its
		// balls reach beyond the surface.
		{"largest jump of the force in 1 ms by a change of level", "%", 100 * m_largestLeap, 0, 12},
		{"error of a block that slides for half a second in steps of 240 Hz", "%", m_motionError,
			100 * SlidingBlock::expectedError(kMotionRate), 10 * SlidingBlock::expectedError(kMotionRate)}};
}

std::vector<scenes::Chart> Dial::charts() const
{
	const auto line = [](const char* name) { return scenes::ChartSeries{name, {}, {}, {}, false, -1}; };
	scenes::Chart errors{"Error of the force", "error accepted [%]", "error [%]",
		{line("accepted"), line("bound (half)"), line("true (half)"), line("true (95 %)")}, true};
	scenes::Chart cost{"What it costs", "error accepted [%]", "", {line("queries a second"), line("spheres"), line("pairs")}, true};
	for (const scenes::AccuracyPoint& p : m_sweep)
	{
		const double percents[] = {p.accepted, p.medianErrorBound, p.middleError, p.error},
					 costs[] = {1e6 / p.microseconds, p.balls, p.pairs};
		for (size_t i = 0; i < 4; ++i) errors.series[i].x.push_back(100 * p.accepted), errors.series[i].y.push_back(100 * percents[i]);
		for (size_t i = 0; i < 3; ++i) cost.series[i].x.push_back(100 * p.accepted), cost.series[i].y.push_back(costs[i]);
	}
	// A marker shows the present setting.
	const auto mark = [&](scenes::Chart& chart, size_t like, double value) {
		chart.series.push_back({"", {m_accepted}, {value}, {}, true, int(like)});
	};
	mark(errors, 1, 100 * m_pair.errorBound);
	mark(errors, 2, 100 * m_nowError);
	mark(cost, 0, 1e6 / std::max(m_nowMicroseconds, 0.1));
	mark(cost, 1, double(m_nowBalls));
	mark(cost, 2, double(m_nowPairs));
	return {errors, cost, m_motion};
}

std::vector<std::string> Dial::report() const
{
	std::vector<std::string> rows;
	for (const scenes::AccuracyPoint& p : m_sweep)
	{
		char row[200];
		std::snprintf(row, sizeof row,
			"accepted %.1f %%: bound %.1f (half of the poses: %.1f), true %.1f (half: %.2f) %%, bound held in %.0f %%, within the accepted "
			"in %.0f %%; %.0f "
			"spheres, %.0f pairs, %.0f us",
			100 * p.accepted, 100 * p.errorBound, 100 * p.medianErrorBound, 100 * p.error, 100 * p.middleError, 100 * p.held, 100 * p.kept,
			p.balls, p.pairs, p.microseconds);
		rows.push_back(row);
	}
	return rows;
}

void Dial::draw(const DrawChoice& choice, DrawList& list)
{
	list.ground = choice.ground;
	list.shadows = choice.shadows;
	list.wireframe = choice.wireframe;
	list.gridCell = 0.02;
	Pose X_WA;
	X_WA.translation.y = m_up;
	const Pose X_WB = X_WA * X_AB(std::max(m_ticks - 1, 0) % kPeriod);
	if (choice.surfaces)
	{
		list.surfaces.push_back({m_solids[0]->surface, X_WA, bodyColour(0), 1, true});
		list.surfaces.push_back({m_solids[1]->surface, X_WB, bodyColour(1), 1, true});
	}
	if (choice.leaves && m_balls)
		for (size_t slot = 0; slot < m_balls->slotCount(); ++slot)
			if (const MomentEllipsoid ball = m_balls->ball(slot); ball.density > 0)
				list.discs.push_back({X_WA * (m_trees[0].origin + ball.center()), normalized(Vec3{ball.nx + 1e-6, ball.ny, ball.nz}),
					0.6 * ball.meanRadius(), 0.25 * ball.meanRadius(), levelColour(0.2 + 0.7 * norm(ball.normal()))});
	if (!choice.wrenches || !(norm(m_force) > 0)) return;
	const Vec3 from = X_WB.translation, tip = from - 0.05 * normalized(m_force);
	list.arrows.push_back({from, tip, 0.0015, {0.80f, 0.18f, 0.12f}});
	char text[80];
	std::snprintf(text, sizeof text, "%.3g N +- %.2g %%, level %d", kStiffness * norm(m_force), 100 * m_pair.errorBound, m_pair.level);
	list.texts.push_back({tip, text, {0.55f, 0.08f, 0.04f}});
}
}  // namespace

std::unique_ptr<BrowsableDemo> makeDial() { return std::make_unique<Dial>(); }
}  // namespace browser
