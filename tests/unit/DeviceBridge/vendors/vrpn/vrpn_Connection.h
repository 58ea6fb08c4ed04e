// SPDX-License-Identifier: Zlib
#pragma once

// The part of VRPN's interface that the plug-in uses, so that it can be compiled and tested without VRPN. Names and signatures:
// vrpn_Configure.h, vrpn_Types.h and vrpn_Connection.h of github.com/vrpn/vrpn, 07.36.
#include <sys/time.h>

#define VRPN_CALLBACK
#define VRPN_API

typedef int vrpn_int32;
typedef float vrpn_float32;
typedef double vrpn_float64;
typedef bool vrpn_bool;

class VRPN_API vrpn_Connection
{
public:
	virtual ~vrpn_Connection(void);
	virtual vrpn_bool doing_okay(void) const;
	virtual vrpn_bool connected(void) const;
	virtual int mainloop(const struct timeval* timeout = nullptr) = 0;
	void removeReference();
};

VRPN_API vrpn_Connection* vrpn_get_connection_by_name(const char* cname, const char* local_in_logfile_name = nullptr,
	const char* local_out_logfile_name = nullptr, const char* remote_in_logfile_name = nullptr,
	const char* remote_out_logfile_name = nullptr, const char* NIC_IPaddress = nullptr, bool force_reopen = false);
