// SPDX-License-Identifier: Zlib
#pragma once

namespace devicebridge
{
/// Holds the force at zero if the tool is in contact when forces are enabled, until the tool is free once.
class StartInsideLatch
{
public:
	void arm() noexcept { m_armed = true; }
	/// Returns true while the force must stay zero.
	bool holds(bool inContact) noexcept
	{
		m_holding = inContact && (m_holding || m_armed);
		m_armed = false;
		return m_holding;
	}

private:
	bool m_armed = true, m_holding = false;
};
}  // namespace devicebridge
