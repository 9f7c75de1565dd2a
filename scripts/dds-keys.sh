#!/usr/bin/env bash
# Keys, certificates and permissions for DDS Security: who may read a line's telemetry, and who may command its axes.
#
#   scripts/dds-keys.sh FOLDER new                     an authority, and the rules of its domain
#   scripts/dds-keys.sh FOLDER add NAME line           a line: publishes, and takes commands
#   scripts/dds-keys.sh FOLDER add NAME observe        may read telemetry
#   scripts/dds-keys.sh FOLDER add NAME command        may read telemetry, and command
#
# The name in a certificate is NAME, with a number behind it where that is needed (see common_name). Each NAME gets a folder FOLDER/NAME with the six files that Fast DDS and Cyclone DDS ask for. What is in FOLDER/authority stays where it is
# made: who has authority.key can let in whomever he likes.
set -euo pipefail

readonly DAYS=3650
readonly TELEMETRY=(driveline/axis_telemetry driveline/line_status 'driveline/v1/axis_batch' driveline/v1/event driveline/v1/slave
  driveline/v1/topology driveline/v1/cycle_statistics driveline/v1/axis_state rt/diagnostics rt/joint_states)
readonly COMMANDS=(driveline/v1/command driveline/v1/setpoints)
readonly ANSWERS=(driveline/v1/command_answer driveline/v1/stream_status)

fail() {
  echo "dds-keys: $1" >&2
  exit 2
}

usage() {
  cat <<'TEXT'
usage: dds-keys.sh FOLDER new
       dds-keys.sh FOLDER add NAME line|observe|command
Creates an authority, keys, certificates and permissions for DDS Security.
TEXT
}

misused() {
  usage >&2
  exit 2
}

quietly() {
  local said
  said=$("$@" 2>&1) || fail "${said##*$'\n'}"
}

sign() { # FILE.xml -> FILE.p7s
  quietly openssl smime -sign -in "$1" -text -out "${1%.xml}.p7s" -signer "$folder/authority/authority.pem" \
    -inkey "$folder/authority/authority.key"
}

# Cyclone DDS takes none above 230 here.
domains='<domains><id_range><min>0</min><max>230</max></id_range></domains>'

new_authority() {
  [[ ! -e $folder/authority ]] || fail "$folder/authority already exists"
  umask 077
  mkdir -p "$folder/authority"
  quietly openssl ecparam -name prime256v1 -genkey -noout -out "$folder/authority/authority.key"
  quietly openssl req -x509 -new -key "$folder/authority/authority.key" -sha256 -days $DAYS -subj "/CN=authority" \
    -out "$folder/authority/authority.pem"
  cat >"$folder/authority/governance.xml" <<XML
<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
     xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
  <domain_access_rules>
    <domain_rule>
      $domains
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>NONE</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>ENCRYPT</metadata_protection_kind>
          <data_protection_kind>NONE</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
XML
  sign "$folder/authority/governance.xml"
}

topics() { # publish|subscribe TOPIC...
  local kind=$1 topic
  shift
  [[ $# -gt 0 ]] || return 0
  echo "<$kind><topics>"
  for topic in "$@"; do echo "<topic>$topic</topic>"; done
  echo "</topics></$kind>"
}

rules() { # ROLE
  case $1 in
    line)
      topics publish "${TELEMETRY[@]}" "${ANSWERS[@]}"
      topics subscribe "${COMMANDS[@]}"
      ;;
    observe)
      topics subscribe "${TELEMETRY[@]}"
      ;;
    command)
      topics publish "${COMMANDS[@]}"
      topics subscribe "${TELEMETRY[@]}" "${ANSWERS[@]}"
      ;;
    *) fail "\"$1\" is not a role; line, observe or command is expected" ;;
  esac
}

first_byte() { # COMMON-NAME: of the SHA-256 of the subject name in DER, from which the participant gets its GUID (DDS Security, 9.3.3)
  local n=${#1} der
  der=$(printf '\\x%02x' 0x30 $((n + 11)) 0x31 $((n + 9)) 0x30 $((n + 7)) 0x06 0x03 0x55 0x04 0x03 0x0c "$n")
  printf '%d' "0x$({ printf '%b' "$der"; printf '%s' "$1"; } | sha256sum | cut -c 1-2)"
}

# The participant with the lower GUID begins the handshake. Cyclone DDS 0.10 does not understand how Fast DDS 2.9 begins one, which a line uses;
# so lines have names whose GUID is high, and others lower ones.
# Permissions are those of a name: no two identities have the same, and one whose folder was deleted keeps its own.
common_name() { # NAME ROLE
  local name=$1 number=0 byte
  while true; do
    byte=$(first_byte "$name")
    if [[ -e $folder/authority/names/$name ]]; then
      :
    elif [[ $2 == line ]]; then
      ((byte < 0xF0)) || break
    else
      ((byte >= 0xF0)) || break
    fi
    number=$((number + 1))
    name=$1-$number
  done
  echo "$name"
}

add_identity() { # NAME ROLE
  local own=$folder/$1 permitted subject
  [[ $1 =~ ^[A-Za-z0-9_-]+$ && $1 != authority ]] || fail "\"$1\" is not a valid name: use letters, digits, - and _"
  [[ -e $folder/authority/authority.key ]] || fail "$folder has no authority; create it with \"$0 $folder new\""
  [[ ! -e $own ]] || fail "$own already exists"
  permitted=$(rules "$2")
  subject=CN=$(common_name "$1" "$2")
  umask 077
  mkdir "$own"
  mkdir -p "$folder/authority/names"
  : >"$folder/authority/names/${subject#CN=}"
  quietly openssl ecparam -name prime256v1 -genkey -noout -out "$own/private_key.ec"
  quietly openssl pkcs8 -topk8 -nocrypt -in "$own/private_key.ec" -out "$own/private_key.pem"
  quietly openssl req -new -key "$own/private_key.pem" -subj "/$subject" -utf8 -out "$own/request.pem"
  quietly openssl x509 -req -in "$own/request.pem" -CA "$folder/authority/authority.pem" \
    -CAkey "$folder/authority/authority.key" -CAcreateserial -sha256 -days $DAYS -out "$own/certificate.pem"
  cat >"$own/permissions.xml" <<XML
<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
     xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">
  <permissions>
    <grant name="$1">
      <subject_name>$subject</subject_name>
      <validity>
        <not_before>$(date -u -d yesterday +%Y-%m-%dT%H:%M:%S)</not_before>
        <not_after>$(date -u -d "+$DAYS days" +%Y-%m-%dT%H:%M:%S)</not_after>
      </validity>
      <allow_rule>
        $domains
        $permitted
      </allow_rule>
      <default>DENY</default>
    </grant>
  </permissions>
</dds>
XML
  sign "$own/permissions.xml"
  cp "$folder/authority/authority.pem" "$own/identity_ca.pem"
  cp "$folder/authority/authority.pem" "$own/permissions_ca.pem"
  cp "$folder/authority/governance.p7s" "$own/governance.p7s"
  rm "$own/private_key.ec" "$own/request.pem" "$own/permissions.xml"
}

if [[ ${1:-} == --help ]]; then
  usage
  exit 0
fi
folder=${1:-}
case ${2:-} in
  new)
    [[ $# -eq 2 ]] || misused
    new_authority
    ;;
  add)
    [[ $# -eq 4 ]] || misused
    add_identity "$3" "$4"
    ;;
  *) misused ;;
esac
