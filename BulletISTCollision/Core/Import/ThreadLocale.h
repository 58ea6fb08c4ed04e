// SPDX-License-Identifier: Zlib
#pragma once

#include <locale.h>
#ifdef __APPLE__
#include <xlocale.h>
#endif

namespace ist
{
/// During its lifetime, this thread reads and writes numbers in another locale. Other threads and the program's locale do not change.
class ThreadLocale
{
public:
	explicit ThreadLocale(locale_t locale) : m_before(uselocale(locale)) {}
	~ThreadLocale() { uselocale(m_before); }
	ThreadLocale(const ThreadLocale&) = delete;
	ThreadLocale& operator=(const ThreadLocale&) = delete;

	locale_t before() const { return m_before; }

private:
	locale_t m_before;
};

/// The locale "C", in which numbers have a decimal point and letters are ASCII.
class PlainLocale
{
public:
	PlainLocale() : m_locale(newlocale(LC_ALL_MASK, "C", nullptr)) {}
	~PlainLocale()
	{
		if (m_locale) freelocale(m_locale);
	}
	PlainLocale(const PlainLocale&) = delete;
	PlainLocale& operator=(const PlainLocale&) = delete;

	/// The locale; null if there is no memory for it. A ThreadLocale of null changes nothing.
	locale_t get() const { return m_locale; }

private:
	locale_t m_locale;
};
}  // namespace ist
