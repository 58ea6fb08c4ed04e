// SPDX-License-Identifier: Zlib
#include "demos/browser/DemoSolid.h"

#include "BulletISTCollision/Core/MeshShapes.h"
#include "BulletISTCollision/Core/PressureField.h"
#include "BulletISTCollision/Core/TreeLevels.h"
#include "demos/scenes/OverlapQuadrature.h"

#include <algorithm>
#include <chrono>
#include <cstdio>

using namespace ist;

namespace browser
{
namespace
{
constexpr double kSize = 0.2, kBall = 0.025, kStiffness = 1e7, kTruthEvery = 0.5;

/// Error against cost: the user says what error of the force he accepts, and the coarsest level answers that keeps to it: its bound is the
/// distance of its force from that of the leaves, plus the error bar of the leaves. (The bars of coarse levels alone promise too much where
/// the contact is as small as their balls.)
class Dial : public BrowsableDemo
{
public:
	std::optional<Error> prepare(const DemoOptions& options) override
	{
		Result<Mesh> mesh = chosenMesh(options, kSize, knotMesh(kSize));
		if (!mesh) return mesh.error();
		const Mesh meshes[] = {mesh.value(), makeSphereMesh(kBall, 4)};
		for (const int i : {0, 1})
		{
			if (auto error = makeSolid(m_solids[i], i ? "ball" : "body", meshes[i], i ? 800 : 3000, options)) return error;
			m_trees[i] = *m_solids[i]->tree;
			m_trees[i].levels = buildLevels(m_trees[i].law);
		}
		m_levels = int(m_trees[0].levels.size() + m_trees[1].levels.size());
		m_truth = std::make_unique<scenes::OverlapQuadrature>(m_solids[0]->mesh, m_solids[1]->mesh);
		const Box box = bounds(m_solids[0]->mesh);
		m_up = -box.lower.y;
		for (const Vec3& p : m_solids[0]->mesh.vertices)
			if (p.y == box.upper.y) m_top = p;
		return std::nullopt;
	}
	std::optional<Error> restart() override
	{
		m_time = m_nextTruth = m_nextSample = 0;
		m_rows.clear();
		for (Curve* curve : {&m_bar, &m_rate, &m_pairs, &m_error}) curve->values.clear();
		ask();
		return std::nullopt;
	}
	void step(double seconds) override
	{
		m_time += seconds;
		ask();
		if (m_time < m_nextSample) return;
		m_nextSample += 1.0 / 60;
		append(m_bar, 100 * m_answer.bar);
		append(m_rate, 1e6 / std::max(m_answer.microseconds, 0.1));
		append(m_pairs, double(m_answer.pairs));
		append(m_error, 100 * m_trueError);
	}
	double stepSize() const override { return 1.0 / 60; }
	double duration() const override { return 2; }
	double time() const override { return m_time; }
	Viewpoint viewpoint() const override { return {{m_top.x, m_up + m_top.y + 0.01, m_top.z}, 0.28, 0.7, 0.4}; }
	DrawChoice firstChoice() const override { return {.leaves = true}; }
	void draw(const DrawChoice& choice, DrawList& list) override;
	std::vector<Parameter> parameters() override { return {{"error accepted", "%", &m_accepted, 0.5, 50, false, true}}; }
	std::vector<Figure> figures() const override
	{
		return {{"level", "", double(m_answer.level)},
				{"pairs", "", double(m_answer.pairs)},
				{"bound of the error", "%", 100 * m_answer.bar},
				{"true error, by quadrature on the triangles", "%", 100 * m_trueError, 0, std::max(m_accepted, 200 * m_finest.bar)}};
	}
	std::vector<Curve> curves() const override { return {m_bar, m_error, m_rate, m_pairs}; }
	std::vector<std::string> report() const override { return m_rows; }

private:
	struct Answer
	{
		int level = 0;
		long long pairs = 0;
		double bar = 0, microseconds = 0;
		Vec3 force;
		const BallTree* balls = nullptr;
	};
	static void append(Curve& curve, double value)
	{
		if (curve.values.size() == 600) curve.values.erase(curve.values.begin());
		curve.values.push_back(float(value));
	}
	Pose X_AB() const
	{
		Pose X;
		X.translation = m_top + Vec3{0.004 * std::sin(3.1 * m_time), kBall - 0.010 + 0.003 * std::sin(2 * m_time), 0.004 * std::cos(2.3 * m_time)};
		X.rotation = rotationMatrix(quaternionFromRotationVector({0.3 * m_time, 0.5, 0}));
		return X;
	}
	Answer askLevel(int level)
	{
		QueryOptions options;
		options.level = level;
		const auto start = std::chrono::steady_clock::now();
		const OverlapResult result = queryOverlap(m_trees[0], m_trees[1], X_AB(), m_workspace, options);
		Answer answer;
		answer.microseconds = 1e6 * std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
		answer.level = result.level;
		answer.pairs = result.total.pairs;
		answer.balls = result.ballsA;
		answer.force = pressureWrench(result.total, {kStiffness, 0.5, 0.5}).force;
		const double sigma = overlapError(result.total, m_trees[0].errorLength() + m_trees[1].errorLength(), kStiffness).force;
		answer.bar = norm(answer.force) > 0 ? sigma / norm(answer.force) : 0;
		return answer;
	}
	double boundOf(const Answer& answer) const
	{
		const double force = norm(m_finest.force);
		return force > 0 ? norm(answer.force - m_finest.force) / force + m_finest.bar : 0;
	}
	void ask()
	{
		m_finest = askLevel(0);
		for (int level = m_levels; level >= 0; --level)
		{
			m_answer = askLevel(level);
			m_answer.bar = boundOf(m_answer);
			if (100 * m_answer.bar <= m_accepted) break;
		}
		if (m_time < m_nextTruth) return;
		m_nextTruth = m_time + kTruthEvery;
		judge();
	}
	/// All levels beside the integral over the triangles.
	void judge()
	{
		m_rows.clear();
		const Vec3 truth = kStiffness * m_truth->integrate(X_AB(), {}, 48, 20000).wrench().force;
		const auto errorOf = [&](const Answer& a) { return norm(truth) > 0 ? norm(a.force - truth) / norm(truth) : 0; };
		m_trueError = errorOf(m_answer);
		for (int level = m_levels; level >= 0; --level)
		{
			const Answer a = askLevel(level);
			char row[120];
			std::snprintf(row, sizeof row, "%slevel %d: %lld pairs, %.0f us, bound %.1f %%, true error %.1f %%", a.level == m_answer.level ? "> " : "", a.level, a.pairs,
						  a.microseconds, 100 * boundOf(a), 100 * errorOf(a));
			m_rows.push_back(row);
		}
	}

	SolidPtr m_solids[2];
	InnerSphereTree m_trees[2];
	std::unique_ptr<scenes::OverlapQuadrature> m_truth;
	QueryWorkspace m_workspace;
	Answer m_answer, m_finest;
	std::vector<std::string> m_rows;
	Curve m_bar{"bound of the error", "%", {}}, m_rate{"queries a second", "Hz", {}}, m_pairs{"pairs", "", {}}, m_error{"true error", "%", {}};
	Vec3 m_top;
	int m_levels = 0;
	double m_time = 0, m_nextTruth = 0, m_nextSample = 0, m_trueError = 0, m_accepted = 5, m_up = 0;
};

void Dial::draw(const DrawChoice& choice, DrawList& list)
{
	list.ground = choice.ground;
	list.shadows = choice.shadows;
	list.wireframe = choice.wireframe;
	list.gridCell = 0.02;
	Pose X_WA;
	X_WA.translation.y = m_up;
	const Pose X_WB = X_WA * X_AB();
	if (choice.surfaces)
	{
		list.surfaces.push_back({m_solids[0]->surface, X_WA, bodyColour(0), 1, true});
		list.surfaces.push_back({m_solids[1]->surface, X_WB, bodyColour(1), 1, true});
	}
	if (choice.leaves && m_answer.balls)
		for (const MomentEllipsoid& ball : m_answer.balls->balls)
			if (ball.density > 0)
				list.discs.push_back({X_WA * (m_trees[0].origin + ball.center()), normalized(Vec3{ball.nx + 1e-6, ball.ny, ball.nz}), 0.6 * ball.meanRadius(),
									  0.25 * ball.meanRadius(), levelColour(0.2 + 0.7 * norm(ball.normal()))});
	if (!choice.wrenches || !(norm(m_answer.force) > 0)) return;
	const Vec3 from = X_WB.translation, tip = from - 0.05 * normalized(m_answer.force);
	list.arrows.push_back({from, tip, 0.0015, {0.80f, 0.18f, 0.12f}});
	char text[80];
	std::snprintf(text, sizeof text, "%.3g N +- %.2g %%, level %d", norm(m_answer.force), 100 * m_answer.bar, m_answer.level);
	list.texts.push_back({tip, text, {0.55f, 0.08f, 0.04f}});
}
}  // namespace

std::unique_ptr<BrowsableDemo> makeDial() { return std::make_unique<Dial>(); }
}  // namespace browser
