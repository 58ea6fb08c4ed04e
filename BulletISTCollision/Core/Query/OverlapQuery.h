// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Base/InstructionSet.h"
#include "BulletISTCollision/Core/Geometry/AnalyticField.h"
#include "BulletISTCollision/Core/Tree/InnerSphereTree.h"

#include <cstddef>
#include <memory>

namespace ist
{
/// Symmetric 6x6 matrix, linear part first, row-major upper triangle (21 entries).
struct SymmetricMatrix6
{
	double m[21] = {};
	static constexpr int index(int i, int j) { return i <= j ? i * (11 - i) / 2 + j : index(j, i); }
	double operator()(int i, int j) const { return m[index(i, j)]; }
	double& operator()(int i, int j) { return m[index(i, j)]; }
};

/// Which fields press, for `OverlapIntegrals::damping`: that of A with weight A, that of B with weight B, neither negative. Both 0: none.
struct DampingWeights
{
	double A = 0, B = 0;
};
inline bool operator==(const DampingWeights& a, const DampingWeights& b) { return a.A == b.A && a.B == b.B; }
inline bool operator!=(const DampingWeights& a, const DampingWeights& b) { return !(a == b); }

/// Integrals over the overlap of A and B (or over one patch of it), free of materials but for the damping's weights. Axes of A's mesh
/// frame; moments are taken about A's `origin` (its centre of mass). Derived in docs/model.md, section 3. dd = d_i d_j, L =
/// volume that two ellipsoids share in units of their densities (Lens.h; for Model::Inner the lens of two balls), C = its centroid, m =
/// mean outward normal there: a leaf has one, m(c), that of a merged ball changes over it (NormalGradient); area n = minus the gradient of
/// L by c_i - c_j, with n of unit length.
struct OverlapIntegrals
{
	double volume = 0;                        ///< sum dd L [m^3]
	Vec3 firstMoment;                         ///< sum dd L C [m^4]
	double secondMoment[6] = {};              ///< sum dd L C C^T: xx, yy, zz, xy, xz, yz [m^5]; for friction
	Wrench normalA, normalB;                  ///< sum dd L m_i, sum dd L m_j and sum C x the same: Int n_A dV, Int n_B dV
	Wrench line;                              ///< sum dd L n and sum C x the same: the paper's eq. (1) at rest; only with Model::Inner
	Vec3 areaVector;                          ///< sum dd area n [m^2]: gradient of V, pointing where A must move to leave B
	SymmetricMatrix6 stiffnessA, stiffnessB;  ///< sum dd area sym(g_n g_w^T) with w = -m_i (A's field), w = m_j (B's field); not projected
	/// sum dd L G G^T with w = w_B m_j - w_A m_i, which is the direction in which the pair presses, and G = (w, C x w): over twists of A,
	/// the square of the speed at which the pair comes together, weighted with its pressure [m^3, m^4, m^5]. Zero where `dampingWeights`
	/// are.
	SymmetricMatrix6 damping;
	DampingWeights dampingWeights;
	double depthA = 0, depthB = 0;  ///< sum dd L (q_i - m_i(c_i).(C - c_i)) and the same of j: Int depth dV [m^4]
	int64_t pairs = 0;              ///< intersecting pairs

	void add(const OverlapIntegrals& other);
	/// All but the number of pairs times `factor`.
	void scale(double factor);
};

/// Which parts speak for a body.
enum class Model
{
	Law,   ///< leaves (default)
	Cell,  ///< unsplit cells: best volume
	Inner  ///< packed spheres: a lower bound of the volume; their normals and depths count as zero
};

enum class QueryStatus
{
	Ok,
	InvalidPose,     ///< not finite or not rigid, or an analytic field that is not valid; nothing else in the result was touched
	EmptyTree,       ///< of a body: it has no tree for the model
	Unsupported,     ///< options that do not go together, a level that the two do not have, a level or a budget with an analytic field
	BudgetTooSmall,  ///< more pairs than `maxPairs` even at the coarsest level: no answer
	InstructionSet   ///< BULLETHAPTICS_ISA, or the workspace's maker, names one that cannot run here
};
const char* toString(QueryStatus status);

struct QueryOptions
{
	Model model = Model::Law;
	int level =
		-1;  ///< -1 or 0: the leaves; each step above leaves a third of one body's balls, of the larger tree's. Only with Model::Law
	/// Not negative: a level from `level` on with at most so many intersecting pairs, the finest that a few looks find; each look
	/// ends at the budget, all together find less than three times as many pairs. Only with Model::Law.
	int64_t maxPairs = -1;
	/// Within a budget: levels fade into each other as the number of pairs changes, two at most at a time and both within the budget, so
	/// that the force does not leap where the level changes. All looks together find less than four times the budget. Not with `sortPairs`.
	bool blend = false;
	/// Above 0: so much of the answer, up to 1, is that of `otherLevel`, the rest that of `level`; for fading from one to the other. Costs
	/// both. Only with Model::Law, without a budget, `sortPairs` and `listMeetingBounds`; not of an analytic field.
	double otherShare = 0;
	int otherLevel = 0;
	bool stiffness = true;   ///< fill stiffnessA/B
	DampingWeights damping;  ///< fill `damping` for fields of these weights; not with Model::Inner
	bool patches = true;     ///< group the pairs; otherwise one patch
	bool sortPairs = false;  ///< keep the pair list in the workspace in a reproducible order for visiting
	/// The list also has pairs whose bounding balls meet though they share nothing (lens 0); one patch; not within a budget.
	bool listMeetingBounds = false;
	/// Nothing while the packed spheres of both bodies are apart. Leaves reach beyond the surface by up to a gap, so bodies that only touch
	/// already press a little; with the gate they do not, but contact shallower than the gaps is lost too. Multiplies the integrals, not
	/// the listed pairs; the error bar does not know what it takes. Costs a query of the packed spheres (Kernels/InnerOverlap.h).
	bool requireInnerOverlap = false;
	bool gate = false;  ///< Former name of `requireInnerOverlap`, until 0.4: one of the two is enough.
};

struct QueryCapacity
{
	int pairs = 200000;  ///< where patches need a longer list, a coarser level answers; without levels, and for visitors, the sums
						 ///< stay exact, but come as one patch, and the list is cut
	int patches = 8;
	int listEntries = 65536;  ///< pairs of subtrees in flight, in each of two lists; fewer are opened at a time when it is small
};

/// One intersecting pair, for visitors: indices into the `balls` of the result's trees, and the lens.
struct OverlapPair
{
	uint32_t ballA = 0, ballB = 0;
	float lens = 0;  ///< L [m^3]
	float area = 0;  ///< [m^2]; 0 when one contains the other
	Vec3 centroid;   ///< C, A's mesh axes, relative to A's origin
	Vec3 normal;     ///< n
};

/// Slots of the largest tree of a body for Model::Law, levels among them: the room that a query needs grows with it.
std::size_t mostSlots(const InnerSphereTree& body);

/// What a workspace needs for trees beyond its capacity, made by a thread that may allocate for one that may not. 120 bytes a slot of B, 24
/// of A.
class QueryBuffers
{
public:
	/// For all queries of A and B with Model::Law, and of bodies with no more slots.
	QueryBuffers(const InnerSphereTree& A, const InnerSphereTree& B);
	~QueryBuffers();

	struct Implementation;
	Implementation& implementation() { return *m_impl; }

private:
	std::unique_ptr<Implementation> m_impl;
};

/// All memory of a query. One per thread; reuse it: a query allocates nothing but where a tree has more slots than any before, and none
/// of these was made room for.
class QueryWorkspace
{
public:
	/// With the instruction set of `chosenInstructionSet`.
	explicit QueryWorkspace(const QueryCapacity& capacity = {});
	QueryWorkspace(const QueryCapacity& capacity, InstructionSet set);
	~QueryWorkspace();
	QueryWorkspace(QueryWorkspace&&) noexcept;
	QueryWorkspace& operator=(QueryWorkspace&&) noexcept;
	const QueryCapacity& capacity() const;
	/// Room as a QueryBuffers has it.
	void reserve(const InnerSphereTree& A, const InnerSphereTree& B);
	/// Makes the lists of pairs of leaves resident: 30 MB with the default capacity. Otherwise a query that finds more pairs than any
	/// before it waits for the system to provide pages. Call it for a thread that must not wait, such as that of a haptic device.
	void makeResident();
	/// Takes what is larger there and leaves its own, which is of no more use. Once for each room. Allocates and frees nothing.
	void take(QueryBuffers& room) noexcept;

	struct Implementation;
	Implementation& implementation() { return *m_impl; }

private:
	std::unique_ptr<Implementation> m_impl;
};

struct OverlapResult
{
	QueryStatus status = QueryStatus::Ok;
	OverlapIntegrals total;
	const OverlapIntegrals* patches = nullptr;  ///< in the workspace, valid until its next use; they sum to `total`
	int patchCount = 0;
	bool pairListComplete = true;        ///< false: more pairs than the capacity, so one patch and a cut list
	const OverlapPair* pairs = nullptr;  ///< in the workspace; filled only on `QueryOptions::sortPairs`
	int pairCount = 0;
	const BallTree *ballsA = nullptr, *ballsB = nullptr;  ///< the trees that the pairs' indices point into
	int level = 0;                                        ///< at which it was answered; the error bar (PressureField.h) grows with it
	double levelShare = 1;  ///< of `level` in the answer; the rest is that of `otherLevel` (`QueryOptions::blend`, `otherShare`)
	int otherLevel = 0;
	bool coarsened = false;                                 ///< coarser than asked for, to keep within `maxPairs` or the capacity
	int64_t nodeVisits = 0, blockPairs = 0, ballTests = 0;  ///< work done, independent of the machine
};

class VerletList;

/// Overlap of two bodies. X_AB: pose of B's mesh frame in A's mesh frame. `memory`: what these two remember from query to query
/// (VerletList.h); null: nothing. O(pairs), no allocation.
OverlapResult queryOverlap(const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, QueryWorkspace& workspace,
	const QueryOptions& options = {}, VerletList* memory = nullptr);

/// Overlap of A with a body in closed form. X_AF: pose of the field's frame in A's mesh frame. B's field is that of the body itself:
/// `normalB` = Int n_B dV with the normals of its nearest surface points, `depthB` with its depth; its stiffness holds its curvature. All
/// that belongs to A is as with a tree. A pair is a leaf that reaches into the field; patches are told apart by the field's normals.
/// Leaves larger than the field's grain are divided (FieldClipper.h). O(leaves in reach), no allocation but at the first of its kind.
OverlapResult queryField(
	const InnerSphereTree& A, const AnalyticField& field, const Pose& X_AF, QueryWorkspace& workspace, const QueryOptions& options = {});

/// Overlap of A with the half-space { x : normal . x <= offset } of A's mesh frame (unit normal, pointing out of the solid): exact caps of
/// the ellipsoids, one patch, `normalB` = volume * normal.
OverlapResult queryHalfSpace(
	const InnerSphereTree& A, const Vec3& normal, double offset, QueryWorkspace& workspace, const QueryOptions& options = {});

/// Slow, obvious reference: all pairs in double, one patch. For tests and benchmarks.
OverlapResult queryOverlapBruteForce(
	const InnerSphereTree& A, const InnerSphereTree& B, const Pose& X_AB, Model model = Model::Law, const DampingWeights& damping = {});
}  // namespace ist
