// SPDX-License-Identifier: Zlib
#include "BulletISTCollision/Core/Base/SpinPause.h"
#include "BulletISTCollision/Core/Base/SteadyTime.h"
#include "BulletISTCollision/Core/Query/QueryHelperState.h"

namespace ist
{
QueryHelper::Implementation::Implementation(const QueryCapacity& capacity, double spin) : work(capacity, nullptr), m_spin(spin)
{
	m_thread = std::thread([this] { loop(); });
}

QueryHelper::Implementation::~Implementation()
{
	m_stop = true;
	++m_turn;
	m_turn.notify_one();
	m_thread.join();
}

bool QueryHelper::Implementation::suits(const QueryWorkspace::Implementation& caller) const
{
	// Beside what a search from the roots may list, a list holds the entries that a part begins with.
	constexpr int kBegin = SharedEntries::kMost / kParts + 1;
	const auto hasRoom = [](const QueryWorkspace::Implementation& w) {
		return w.capacity.listEntries >= w.openBatch * kernels::kLeastListEntries + kBegin;
	};
	return work.capacity.pairs >= caller.capacity.pairs && hasRoom(work) && hasRoom(caller);
}

void QueryHelper::Implementation::open(const BallTree& A, const BallTree& B, const Pose& X, const QueryOptions& options,
	const QueryLimits& limits, const kernels::QueryKernel* kernel)
{
	m_A = &A;
	m_B = &B;
	m_X = X;
	m_options = options;
	m_limits = limits;
	work.kernel = kernel;
	work.reserveFor(A, B);
	for (std::atomic<int>& state : m_state) state.store(kPending, std::memory_order_relaxed);
	m_claimed.store(0, std::memory_order_relaxed);
	m_open.store(true, std::memory_order_seq_cst);
	m_turn.fetch_add(1, std::memory_order_seq_cst);
	m_turn.notify_one();
}

bool QueryHelper::Implementation::finished(int part, double microseconds)
{
	const double start = steadyMicroseconds();
	while (m_state[part].load(std::memory_order_acquire) != kDone)
	{
		spinPause();
		if (steadyMicroseconds() - start < microseconds) continue;
		int pending = kPending;
		const bool late = m_state[part].compare_exchange_strong(pending, kTakenBack, std::memory_order_acq_rel);
		partsLate.fetch_add(late, std::memory_order_relaxed);
		return !late;
	}
	return true;
}

void QueryHelper::Implementation::close()
{
	m_claimed.store(kParts, std::memory_order_relaxed);
	m_open.store(false, std::memory_order_seq_cst);
}

void QueryHelper::Implementation::settle() const
{
	while (!isFree()) std::this_thread::yield();
}

void QueryHelper::Implementation::takeParts()
{
	OverlapResult result;
	TreeQuery query(*m_A, *m_B, m_X, work, m_options, m_limits, result);
	if (!query.place()) return;
	for (int part = kParts; claim();)
	{
		--part;
		query.searchPart(entries, part, found[part]);
		int pending = kPending;
		if (!m_state[part].compare_exchange_strong(pending, kDone, std::memory_order_acq_rel)) return;
		partsDone.fetch_add(1, std::memory_order_relaxed);
	}
}

void QueryHelper::Implementation::loop()
{
	uint32_t seen = 0;
	for (;;)
	{
		for (const double start = steadyMicroseconds();
			 m_turn.load(std::memory_order_seq_cst) == seen && steadyMicroseconds() - start < m_spin;)
			spinPause();
		m_turn.wait(seen, std::memory_order_seq_cst);
		seen = m_turn.load(std::memory_order_seq_cst);
		if (m_stop) return;
		// First working, then a look whether there is work: the caller does it the other way round.
		m_working.store(true, std::memory_order_seq_cst);
		if (m_open.load(std::memory_order_seq_cst)) takeParts();
		m_working.store(false, std::memory_order_seq_cst);
	}
}

QueryHelper::QueryHelper(const QueryCapacity& capacity, double spinMicroseconds)
	: m_impl(std::make_unique<Implementation>(capacity, spinMicroseconds))
{}
QueryHelper::~QueryHelper() = default;
void QueryHelper::settle() { m_impl->settle(); }
int64_t QueryHelper::partsDone() const { return m_impl->partsDone; }
int64_t QueryHelper::partsLate() const { return m_impl->partsLate; }
}  // namespace ist
