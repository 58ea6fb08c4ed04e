// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/QueryHelper.h"
#include "BulletISTCollision/Core/Query/TreeQuery.h"

#include <array>
#include <atomic>
#include <thread>

namespace ist
{
/// What a part of a search found: sums, and a run of the list of whoever searched.
struct PartResult
{
	double sums[kernels::kSumCount];
	kernels::SearchCounts counts;
	int begin = 0, count = 0;
	bool complete = true;  ///< the list held them
};

/// Pairs of subtrees that are still to be opened, dealt out in turn to the parts.
struct SharedEntries
{
	static constexpr int kMost = 2048;
	int count = 0;
	std::array<uint32_t, kMost> a, b;
	std::array<float, kMost> x, y, z, r;
	std::array<bool, kMost> openA;
};

struct QueryHelper::Implementation
{
	static constexpr int kParts = 16;
	/// Node visits after which a search is one of the long ones, some ten microseconds; and entries that must be open then: few are left to
	/// a search that is nearly done.
	static constexpr int kLongSearch = 256, kEnough = 64;

	Implementation(const QueryCapacity& capacity, double spin);
	~Implementation();

	/// Whether parts of a workspace's searches fit into the lists of both.
	bool suits(const QueryWorkspace::Implementation& caller) const;
	/// Whether it can take a search. Only then may what follows be written.
	bool isFree() const { return !m_working.load(std::memory_order_seq_cst); }
	void open(const BallTree& A, const BallTree& B, const Pose& X, const QueryOptions& options, const QueryLimits& limits,
		const kernels::QueryKernel* kernel);
	/// Whether there is one more part for who asks: for the caller the next from the first on, for the helper the next from the last on.
	bool claim() { return m_claimed.fetch_add(1, std::memory_order_relaxed) < kParts; }
	/// Whether the helper has done its part within so long [us]; if not, it is the caller's.
	bool finished(int part, double microseconds);
	void close();
	void settle() const;

	SharedEntries entries;
	PartResult found[kParts], own;        ///< by the helper; by the caller, the last
	QueryWorkspace::Implementation work;  ///< the helper's
	std::atomic<int64_t> partsDone{0}, partsLate{0};

private:
	enum State
	{
		kPending,
		kDone,
		kTakenBack
	};
	void loop();
	void takeParts();

	const BallTree *m_A = nullptr, *m_B = nullptr;
	Pose m_X;
	QueryOptions m_options;
	QueryLimits m_limits;
	double m_spin;  ///< [us]
	std::atomic<int> m_claimed{kParts};
	std::atomic<int> m_state[kParts];
	std::atomic<bool> m_open{false}, m_working{false}, m_stop{false};
	std::atomic<uint32_t> m_turn{0};
	std::thread m_thread;  ///< last: all above is there when it begins
};
}  // namespace ist
