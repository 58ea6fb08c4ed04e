// SPDX-License-Identifier: Zlib
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <utility>

namespace devicebridge
{
/// An event. Listeners run in the order in which they were added, on the thread that broadcasts. A listener may add and remove listeners,
/// itself included. An added one is first called by the next broadcast; a removed one is not called again. Other threads may add and remove
/// only while no broadcast runs.
template <class... Args> class Delegate
{
public:
	using Id = std::uint64_t;

	template <class Callable> Id addDelegate(Callable&& callable)
	{
		m_slots.push_back({++m_lastId, true, std::function<void(Args & ...)>(std::forward<Callable>(callable))});
		return m_lastId;
	}

	/// Returns false if no listener has this id.
	bool removeDelegate(Id id)
	{
		for (Slot& slot : m_slots)
		{
			if (slot.id != id || !slot.alive) continue;
			slot.alive = false;
			if (m_depth == 0) sweep();
			else m_sweepDue = true;
			return true;
		}
		return false;
	}

	/// Calls every listener with references to the arguments. Allocates nothing.
	void broadcast(Args&... args)
	{
		const Depth depth(*this);
		const std::size_t count = m_slots.size();
		for (std::size_t i = 0; i < count; ++i)
			if (m_slots[i].alive) m_slots[i].call(args...);
	}

	std::size_t size() const
	{
		std::size_t n = 0;
		for (const Slot& slot : m_slots) n += slot.alive;
		return n;
	}

private:
	struct Slot
	{
		Id id;
		bool alive;
		std::function<void(Args&...)> call;
	};

	struct Depth
	{
		Delegate& owner;
		explicit Depth(Delegate& d) : owner(d) { ++owner.m_depth; }
		~Depth()
		{
			if (--owner.m_depth == 0 && owner.m_sweepDue) owner.sweep();
		}
	};

	void sweep()
	{
		for (std::size_t i = m_slots.size(); i-- > 0;)
			if (!m_slots[i].alive) m_slots.erase(m_slots.begin() + static_cast<std::ptrdiff_t>(i));
		m_sweepDue = false;
	}

	// A deque, because adding must not move the listener that is running.
	std::deque<Slot> m_slots;
	Id m_lastId = 0;
	int m_depth = 0;
	bool m_sweepDue = false;
};
}  // namespace devicebridge
