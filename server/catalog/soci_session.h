#pragma once

// Includes SOCI without Boost. Debian's <soci/soci-config.h> claims Boost support, which its
// headers then include, but libsoci-dev does not depend on Boost; defining its guard first leaves
// out only the templates that exchange Boost's own types. Every file that uses SOCI includes this
// one, before any other header of SOCI.
#ifndef SOCICONFIG_H_INCLUDED
#define SOCICONFIG_H_INCLUDED
#define SOCI_HAVE_CXX11
#define SOCI_HAVE_SQLITE3
#define SOCI_HAVE_POSTGRESQL
#define SOCI_HAVE_VISIBILITY_SUPPORT
#endif

#include <soci/soci.h>
