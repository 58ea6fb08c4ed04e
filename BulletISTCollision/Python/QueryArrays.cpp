// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Python/QueryArrays.h"

#include "BulletISTCollision/Core/Accuracy/ForceErrorBound.h"
#include "BulletISTCollision/Core/Force/ContactPoints.h"
#include "BulletISTCollision/Core/Query/ProximityQuery.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace py = pybind11;

namespace ist::python
{
namespace
{
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Pose poseFromSeven(const double* v, size_t row)
{
	const double n = std::sqrt(v[3] * v[3] + v[4] * v[4] + v[5] * v[5] + v[6] * v[6]);
	if (!(std::fabs(n - 1) <= 1e-3))
		throw py::value_error(
			"pose " + std::to_string(row) + ": the quaternion has length " + std::to_string(n) + "; it must be within 0.001 of 1");
	const Pose X{rotationMatrix({v[3] / n, v[4] / n, v[5] / n, v[6] / n}), {v[0], v[1], v[2]}};
	if (!isFinite(X.translation)) throw py::value_error("pose " + std::to_string(row) + " is not finite");
	return X;
}

Pose poseFromMatrix(const double* v, size_t row)
{
	Pose X;
	for (int i = 0; i < 3; ++i)
		for (int j = 0; j < 3; ++j) X.rotation.m[i][j] = v[4 * i + j];
	X.translation = {v[3], v[7], v[11]};
	const bool lastRow = v[12] == 0 && v[13] == 0 && v[14] == 0 && v[15] == 1;
	if (!lastRow || !isRigid(X)) throw py::value_error("pose " + std::to_string(row) + " is not a rigid transform");
	return X;
}

/// PyBullet's (position, quaternion) as seven numbers; other objects unchanged.
py::object flattened(const py::object& object)
{
	if (!py::isinstance<py::sequence>(object) || py::isinstance<py::array>(object)) return object;
	const py::sequence s(object);
	if (s.size() != 2 || !py::isinstance<py::sequence>(s[0]) || !py::isinstance<py::sequence>(s[1]) || py::len(s[0]) != 3 ||
		py::len(s[1]) != 4)
		return object;
	py::list seven;
	for (const auto& part : s)
		for (const auto& number : part) seven.append(number);
	return seven;
}

/// The columns of the result, allocated once.
class Answer
{
public:
	explicit Answer(const Poses& poses) : m_rows(static_cast<py::ssize_t>(poses.X_AB.size())), m_single(poses.single) {}

	double* numbers(const char* name, std::vector<py::ssize_t> shape = {})
	{
		shape.insert(shape.begin(), m_rows);
		py::array_t<double> column(shape);
		m_columns.emplace_back(name, column);
		return column.mutable_data();
	}
	int64_t* counts(const char* name)
	{
		py::array_t<int64_t> column(m_rows);
		m_columns.emplace_back(name, column);
		return column.mutable_data();
	}
	bool* truths(const char* name)
	{
		py::array_t<bool> column(m_rows);
		m_columns.emplace_back(name, column);
		return column.mutable_data();
	}
	py::dict dict() const
	{
		py::dict d;
		for (const auto& [name, column] : m_columns) d[name] = m_single ? py::object(column[py::int_(0)]) : py::object(column);
		return d;
	}

private:
	py::ssize_t m_rows;
	bool m_single;
	std::vector<std::pair<const char*, py::array>> m_columns;
};

void put(double* column, size_t row, const Vec3& v)
{
	column[3 * row] = v.x;
	column[3 * row + 1] = v.y;
	column[3 * row + 2] = v.z;
}

/// Addresses of each figure's column.
struct Columns
{
	Columns(Answer& a, bool promised)
		: volume(a.numbers("volume")),
		  volumeSigma(a.numbers("volume_sigma")),
		  energy(a.numbers("energy")),
		  centroid(a.numbers("centroid", {3})),
		  normal(a.numbers("normal", {3})),
		  areaVector(a.numbers("area_vector", {3})),
		  force(a.numbers("force", {3})),
		  forceSigma(a.numbers("force_sigma")),
		  torque(a.numbers("torque", {3})),
		  stiffness(a.numbers("stiffness", {6, 6})),
		  distance(a.numbers("distance")),
		  distanceLower(a.numbers("distance_lower")),
		  patches(a.counts("patches")),
		  pairs(a.counts("pairs")),
		  level(a.counts("level")),
		  errorBound(promised ? a.numbers("promise") : nullptr),
		  kept(promised ? a.truths("kept") : nullptr)
	{}
	double *volume, *volumeSigma, *energy, *centroid, *normal, *areaVector, *force, *forceSigma, *torque, *stiffness, *distance,
		*distanceLower;
	int64_t *patches, *pairs, *level;
	double* errorBound;  ///< null, like `kept`, without a force tolerance
	bool* kept;
};

class Bodies
{
public:
	Bodies(const InnerSphereTree& A, const InnerSphereTree& B, double stiffness)
		: m_A(A),
		  m_B(B),
		  m_pair{stiffness, 0.5, 0.5},
		  m_length(0.5 * std::max(A.box.longestSide(), B.box.longestSide()))
	{}

	void describe(const OverlapResult& overlap, const Pose& X_AB, const Columns& to, size_t row) const
	{
		const OverlapIntegrals& total = overlap.total;
		const bool touching = total.volume > 0;
		const OverlapError error = overlapError(overlap, m_A, m_B, m_pair.stiffness);
		const Wrench wrench = pressureWrench(total, m_pair);
		const Distance distance = touching ? Distance{} : queryDistance(m_A, m_B, X_AB);
		const Vec3 none{kNaN, kNaN, kNaN};
		to.volume[row] = total.volume;
		to.volumeSigma[row] = error.volume;
		to.energy[row] = pressureEnergy(total, m_pair);
		put(to.centroid, row, touching ? total.firstMoment / total.volume + m_A.origin : none);
		put(to.normal, row, touching ? normalized(total.areaVector) : none);
		put(to.areaVector, row, touching ? total.areaVector : none);
		put(to.force, row, wrench.force);
		put(to.torque, row, wrench.torque);
		to.forceSigma[row] = error.force;
		const SymmetricMatrix6 stiffness = projectedPositive(pressureStiffness(total, m_pair), m_length);
		for (int i = 0; i < 6; ++i)
			for (int j = 0; j < 6; ++j) to.stiffness[36 * row + static_cast<size_t>(6 * i + j)] = stiffness(i, j);
		to.distance[row] = distance.upper;
		to.distanceLower[row] = distance.lower;
		to.patches[row] = overlap.patchCount;
		to.pairs[row] = total.pairs;
		to.level[row] = overlap.level;
	}

private:
	const InnerSphereTree &m_A, &m_B;
	PressurePair m_pair;
	double m_length;  ///< length that makes rotations comparable with translations [m]
};

void check(const InnerSphereTree& A, const InnerSphereTree& B, double stiffness, int level, int64_t maxPairs, std::optional<double> error)
{
	if (!(stiffness > 0) || !std::isfinite(stiffness)) throw py::value_error("stiffness must be positive and finite");
	if (level < -1) throw py::value_error("level must be at least 0, or -1 for any");
	if (maxPairs < -1) throw py::value_error("max_pairs must not be negative, or -1 for any number");
	if (error && !(*error > 0 && *error <= 1)) throw py::value_error("error must be above 0 and at most 1");
	if ((level > 0 || maxPairs >= 0 || error) && (A.levels.empty() || B.levels.empty()))
		throw py::value_error("level, max_pairs and error need trees with levels; make them by with_levels()");
}

/// Rows are computed independently: a row does not depend on the rows before it.
class Rows
{
public:
	Rows(const InnerSphereTree& A, const InnerSphereTree& B, const QueryOptions& options, std::optional<double> error)
		: m_A(A),
		  m_B(B),
		  m_options(options),
		  m_error(error)
	{}

	OverlapResult answer(const Pose& X_AB, const Columns& to, size_t row)
	{
		if (!m_error) return queryOverlap(m_A, m_B, X_AB, m_workspace, m_options);
		ForceTolerance accepted;
		accepted.error = *m_error;
		const BoundedOverlap promised = queryWithTolerance(m_A, m_B, X_AB, m_workspace, accepted, m_options);
		to.errorBound[row] = promised.errorBound;
		to.kept[row] = promised.kept;
		return promised.overlap;
	}

private:
	const InnerSphereTree &m_A, &m_B;
	QueryOptions m_options;
	std::optional<double> m_error;
	QueryWorkspace m_workspace;
};
}  // namespace

Poses posesFrom(const py::object& object)
{
	const Doubles array = Doubles::ensure(flattened(object));
	if (!array)
	{
		PyErr_Clear();
		throw py::value_error("a pose is 7 numbers tx ty tz qx qy qz qw, a 4x4 matrix, or (position, quaternion)");
	}
	const py::ssize_t n = array.ndim();
	const bool matrices = n >= 2 && n <= 3 && array.shape(n - 1) == 4 && array.shape(n - 2) == 4;
	const bool sevens = n >= 1 && n <= 2 && array.shape(n - 1) == 7;
	if (!matrices && !sevens) throw py::value_error("poses must have the shape (7), (n, 7), (4, 4) or (n, 4, 4)");
	Poses poses;
	const py::ssize_t width = matrices ? 16 : 7;
	poses.single = n == (matrices ? 2 : 1);
	for (size_t row = 0; row < static_cast<size_t>(array.size() / width); ++row)
	{
		const double* v = array.data() + width * static_cast<py::ssize_t>(row);
		poses.X_AB.push_back(matrices ? poseFromMatrix(v, row) : poseFromSeven(v, row));
	}
	return poses;
}

py::dict query(const InnerSphereTree& A, const InnerSphereTree& B, const py::object& object, double stiffness, int level, int64_t maxPairs,
	std::optional<double> error)
{
	check(A, B, stiffness, level, maxPairs, error);
	const Poses poses = posesFrom(object);
	Answer answer(poses);
	const Columns columns(answer, error.has_value());
	const Bodies bodies(A, B, stiffness);
	QueryOptions options;
	options.level = level;
	options.maxPairs = maxPairs;
	QueryStatus status = QueryStatus::Ok;
	size_t row = 0;
	{
		const py::gil_scoped_release others;
		Rows rows(A, B, options, error);
		for (; row < poses.X_AB.size(); ++row)
		{
			const OverlapResult overlap = rows.answer(poses.X_AB[row], columns, row);
			status = overlap.status;
			if (status != QueryStatus::Ok) break;
			bodies.describe(overlap, poses.X_AB[row], columns, row);
		}
	}
	if (status != QueryStatus::Ok) throw py::value_error("pose " + std::to_string(row) + ": " + toString(status));
	return answer.dict();
}

py::dict contactSurface(const InnerSphereTree& A, const InnerSphereTree& B, const py::object& object, double stiffness)
{
	check(A, B, stiffness, -1, -1, {});
	const Poses poses = posesFrom(object);
	if (!poses.single) throw py::value_error("contact_surface takes one pose");
	QueryWorkspace workspace;
	const OverlapResult overlap = queryOverlap(A, B, poses.X_AB[0], workspace);
	if (overlap.status != QueryStatus::Ok) throw py::value_error(toString(overlap.status));
	std::vector<ContactPoint> points(contactPointCount(overlap));
	contactPoints(overlap, {stiffness, 0.5, 0.5}, points.data(), points.size());
	Poses rows;
	rows.X_AB.resize(points.size());
	Answer answer(rows);
	double *position = answer.numbers("position", {3}), *normal = answer.numbers("normal", {3}), *area = answer.numbers("area");
	double *pressure = answer.numbers("pressure"), *error = answer.numbers("error");
	bool* ofA = answer.truths("of_a");
	for (size_t i = 0; i < points.size(); ++i)
	{
		put(position, i, points[i].position + A.origin);
		put(normal, i, points[i].normal);
		area[i] = points[i].area;
		pressure[i] = points[i].pressure;
		error[i] = points[i].error;
		ofA[i] = points[i].ofA;
	}
	return answer.dict();
}

py::tuple distance(const InnerSphereTree& A, const InnerSphereTree& B, const py::object& object)
{
	const Poses poses = posesFrom(object);
	Answer answer(poses);
	double* upper = answer.numbers("upper");
	double* lower = answer.numbers("lower");
	{
		const py::gil_scoped_release others;
		for (size_t row = 0; row < poses.X_AB.size(); ++row)
		{
			const Distance d = queryDistance(A, B, poses.X_AB[row]);
			upper[row] = d.upper;
			lower[row] = d.lower;
		}
	}
	const py::dict columns = answer.dict();
	return py::make_tuple(columns["upper"], columns["lower"]);
}

py::array_t<double> relativePose(const py::object& X_WA, const py::object& X_WB)
{
	const Poses a = posesFrom(X_WA), b = posesFrom(X_WB);
	if (!a.single || !b.single) throw py::value_error("relative_pose takes one pose of each body");
	const Pose X_AB = inverse(a.X_AB[0]) * b.X_AB[0];
	const Quaternion q = quaternion(X_AB.rotation);
	py::array_t<double> seven(7);
	const double values[] = {X_AB.translation.x, X_AB.translation.y, X_AB.translation.z, q.x, q.y, q.z, q.w};
	std::copy(std::begin(values), std::end(values), seven.mutable_data());
	return seven;
}
}  // namespace ist::python
