// SPDX-License-Identifier: Zlib
#pragma once

#include "BulletISTCollision/Core/Query/OverlapQuery.h"

#include <memory>

namespace ist
{
/// A second thread for the queries of one workspace (QueryWorkspace::setHelper). It takes parts of a search that turns out to be long;
/// short ones are not shared. Nobody waits for it: what it has not begun the query does itself, and what it has begun and not finished in
/// good time, too, so that a query needs at most its time alone and one part where the helper loses its processor. The pairs are the same,
/// and sums agree to the rounding of floats with those of a query alone. Not for queries within budgets, nor for one that fills a
/// VerletList. The first query of two trees makes room for them here, too, even where the bodies are apart; where the helper is late with a
/// part then, the next one does.
class QueryHelper
{
public:
	/// `capacity`: as the workspace's. Between queries the thread spins for so many microseconds before it sleeps: waking it costs tens of
	/// them.
	explicit QueryHelper(const QueryCapacity& capacity = {}, double spinMicroseconds = 50);
	~QueryHelper();
	QueryHelper(const QueryHelper&) = delete;
	QueryHelper& operator=(const QueryHelper&) = delete;

	/// Returns when it has let go of the trees of the last query. To be called before one of them goes: it may be late with a part that
	/// nobody wants any more.
	void settle();
	/// Parts of searches that it has done.
	int64_t partsDone() const;
	/// Parts that it had begun and was late with: the query did them again.
	int64_t partsLate() const;

	struct Implementation;
	Implementation& implementation() { return *m_impl; }

private:
	std::unique_ptr<Implementation> m_impl;
};
}  // namespace ist
